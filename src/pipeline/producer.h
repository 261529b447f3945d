// A thread that makes items in order and hands them over through a bounded queue. An exception in
// the thread comes out of next(); destruction stops the thread.
#pragma once

#include <exception>
#include <functional>
#include <optional>
#include <thread>
#include <utility>

#include "src/pipeline/bounded_queue.h"

namespace zygoma {

template <typename Item>
class Producer {
 public:
  // `make` returns the next item, or nothing at the end; it runs on the producer's own thread.
  Producer(std::size_t capacity, std::function<std::optional<Item>()> make)
      : queue_(capacity), thread_([this, make = std::move(make)] { run(make); }) {}

  ~Producer() {
    queue_.close();
    thread_.join();
  }
  Producer(const Producer&) = delete;
  Producer& operator=(const Producer&) = delete;

  std::optional<Item> next() {
    std::optional<Item> item = queue_.pop();
    if (!item && failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
    return item;
  }

 private:
  void run(const std::function<std::optional<Item>()>& make) {
    try {
      while (std::optional<Item> item = make()) {
        if (!queue_.push(std::move(*item))) break;
      }
    } catch (...) {
      failure_ = std::current_exception();
    }
    queue_.close();
  }

  BoundedQueue<Item> queue_;
  std::exception_ptr failure_;  // written before close(), read after pop() saw it closed
  std::thread thread_;          // last: starts when everything else exists
};

}  // namespace zygoma
