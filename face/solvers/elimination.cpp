#include "face/solvers/elimination.h"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>
#include <numeric>
#include <random>

namespace zygoma {
namespace {

// Stored zeros worth the same time as one more front, and as one more row in its list.
constexpr int kZerosPerFront = 100;
constexpr int kZerosPerRow = 2;

constexpr int kAttempts = 12;  // at an order, about a millisecond each for 1000 columns

using Graph = std::vector<std::vector<int>>;

// Approximate minimum degree; columns of equal degree come in the order of their numbers.
std::vector<int> minimum_degree_order(const Graph& neighbors, const std::vector<int>& number) {
  const int n = static_cast<int>(neighbors.size());
  std::vector<Eigen::Triplet<double>> entries;
  for (int v = 0; v < n; ++v) {
    entries.emplace_back(number[v], number[v], 1.0);
    for (const int u : neighbors[v]) entries.emplace_back(number[v], number[u], 1.0);
  }
  Eigen::SparseMatrix<double> pattern(n, n);
  pattern.setFromTriplets(entries.begin(), entries.end());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> permutation;
  Eigen::AMDOrdering<int>()(pattern, permutation);
  std::vector<int> column(n);
  for (int v = 0; v < n; ++v) column[number[v]] = v;
  std::vector<int> order(n);
  for (int p = 0; p < n; ++p) order[p] = column[permutation.indices()[p]];
  return order;
}

// One front per column: the elimination tree with the later neighbours of every column.
std::vector<FrontColumns> eliminate(const Graph& neighbors, const std::vector<int>& order) {
  const int n = static_cast<int>(order.size());
  std::vector<int> place(n);
  for (int p = 0; p < n; ++p) place[order[p]] = p;
  std::vector<FrontColumns> fronts(n);
  const auto earlier = [&](int a, int b) { return place[a] < place[b]; };
  for (int p = 0; p < n; ++p) {
    FrontColumns& front = fronts[p];
    front.own = {order[p]};
    for (const int u : neighbors[order[p]]) {
      if (place[u] > p) front.rest.push_back(u);
    }
    std::sort(front.rest.begin(), front.rest.end(), earlier);
  }
  for (int p = 0; p < n; ++p) {
    FrontColumns& front = fronts[p];
    if (front.rest.empty()) continue;
    front.parent = place[front.rest.front()];
    FrontColumns& parent = fronts[front.parent];
    std::vector<int> both;
    std::set_union(front.rest.begin() + 1,
                   front.rest.end(),
                   parent.rest.begin(),
                   parent.rest.end(),
                   std::back_inserter(both),
                   earlier);
    parent.rest = std::move(both);
  }
  return fronts;
}

int count_rows(const std::vector<int>& columns, const std::vector<int>& weights) {
  int sum = 0;
  for (const int c : columns) sum += weights[c];
  return sum;
}

// The sparsest of several tries.
std::vector<FrontColumns> eliminate_sparsely(const Graph& neighbors,
                                             const std::vector<int>& weights) {
  std::vector<int> number(neighbors.size());
  std::iota(number.begin(), number.end(), 0);
  std::mt19937 random(1);
  std::vector<FrontColumns> best;
  long smallest = 0;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    std::vector<FrontColumns> fronts =
        eliminate(neighbors, minimum_degree_order(neighbors, number));
    long size = 0;
    for (const FrontColumns& front : fronts) {
      const long own = count_rows(front.own, weights);
      size += own * (own + 2 * count_rows(front.rest, weights));
    }
    if (attempt == 0 || size < smallest) {
      smallest = size;
      best = std::move(fronts);
    }
    for (std::size_t k = number.size(); k > 1; --k) std::swap(number[k - 1], number[random() % k]);
  }
  return best;
}

class Merger {
 public:
  Merger(std::vector<FrontColumns> fronts, const std::vector<int>& weights)
      : fronts_(std::move(fronts)), children_(fronts_.size()) {
    for (std::size_t f = 0; f < fronts_.size(); ++f) {
      own_rows_.push_back(count_rows(fronts_[f].own, weights));
      rest_rows_.push_back(count_rows(fronts_[f].rest, weights));
      if (fronts_[f].parent < 0) {
        roots_.push_back(static_cast<int>(f));
      } else {
        children_[fronts_[f].parent].push_back(static_cast<int>(f));
      }
    }
    // Fronts stand in an order of elimination, so every child is complete before its parent.
    for (std::size_t f = 0; f < fronts_.size(); ++f) merge_children(static_cast<int>(f));
  }

  std::vector<FrontColumns> in_postorder() {
    std::vector<FrontColumns> sorted;
    for (const int root : roots_) append(root, sorted);
    return sorted;
  }

 private:
  long zeros_of_merging(int child, int parent) const {
    return static_cast<long>(own_rows_[child]) *
           (own_rows_[parent] + rest_rows_[parent] - rest_rows_[child]);
  }

  void merge_children(int parent) {
    while (!children_[parent].empty()) {
      const auto best =
          std::min_element(children_[parent].begin(), children_[parent].end(), [&](int a, int b) {
            return zeros_of_merging(a, parent) < zeros_of_merging(b, parent);
          });
      const int child = *best;
      if (zeros_of_merging(child, parent) > kZerosPerFront + kZerosPerRow * rest_rows_[child])
        return;
      children_[parent].erase(best);
      std::vector<int>& own = fronts_[parent].own;
      own.insert(own.begin(), fronts_[child].own.begin(), fronts_[child].own.end());
      own_rows_[parent] += own_rows_[child];
      children_[parent].insert(
          children_[parent].end(), children_[child].begin(), children_[child].end());
    }
  }

  int append(int front, std::vector<FrontColumns>& sorted) {
    std::vector<int> places;
    for (const int child : children_[front]) places.push_back(append(child, sorted));
    const int place = static_cast<int>(sorted.size());
    for (const int child : places) sorted[child].parent = place;
    sorted.push_back({-1, std::move(fronts_[front].own), std::move(fronts_[front].rest)});
    return place;
  }

  std::vector<FrontColumns> fronts_;
  std::vector<std::vector<int>> children_;
  std::vector<int> own_rows_;
  std::vector<int> rest_rows_;
  std::vector<int> roots_;
};

// Fronts for the columns eliminated one by one.
std::vector<FrontColumns> merged(std::vector<FrontColumns> columns,
                                 const std::vector<int>& weights) {
  std::vector<int> place(columns.size());
  std::vector<FrontColumns> fronts = Merger(std::move(columns), weights).in_postorder();
  int next = 0;
  for (const FrontColumns& front : fronts) {
    for (const int c : front.own) place[c] = next++;
  }
  for (FrontColumns& front : fronts) {
    std::sort(
        front.rest.begin(), front.rest.end(), [&](int a, int b) { return place[a] < place[b]; });
  }
  return fronts;
}

}  // namespace

std::vector<FrontColumns> plan_elimination(const Graph& neighbors,
                                           const std::vector<int>& weights) {
  return merged(eliminate_sparsely(neighbors, weights), weights);
}

std::vector<FrontColumns> plan_elimination_in_order(const Graph& neighbors,
                                                    const std::vector<int>& weights) {
  std::vector<int> order(neighbors.size());
  std::iota(order.begin(), order.end(), 0);
  return merged(eliminate(neighbors, order), weights);
}

}  // namespace zygoma
