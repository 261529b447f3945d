#include "face/appearance.h"

#include <algorithm>
#include <cmath>

#include "face/noise.h"

namespace zygoma {
namespace {

using Colour = Eigen::Vector3f;

constexpr double kHalfWidth = 176.0;
constexpr double kHalfHeight = 216.0;
constexpr double kMiddleY = -10.0;
constexpr double kZoom = 1.7;  // texels per mm in the middle over the mean, roughly

double squeeze(double s) { return std::asinh(kZoom * s) / std::asinh(kZoom); }
double stretch(double s) { return std::sinh(s * std::asinh(kZoom)) / kZoom; }

Colour mix(const Colour& a, const Colour& b, double t) {
  return a + static_cast<float>(std::clamp(t, 0.0, 1.0)) * (b - a);
}

// A soft spot of blood or shade: multiplies the tone, full in the middle.
struct Spot {
  double x, y, radius_x, radius_y;
  double red, green, blue;
};
constexpr Spot kSpots[] = {
    {39, -31, 21, 16, 1.01, 0.935, 0.93},   // cheeks
    {0, -38, 9, 8, 1.01, 0.93, 0.925},      // tip of the nose
    {13, -41, 6, 6, 1.00, 0.93, 0.925},     // wings
    {0, -96, 18, 11, 1.01, 0.965, 0.96},    // chin
    {0, 48, 50, 22, 1.01, 1.01, 0.99},      // forehead
    {31, -13, 13, 5, 0.955, 0.91, 0.92},    // under the eyes
    {33, 10, 16, 6, 0.92, 0.86, 0.84},      // upper lids
    {15, 4, 6, 8, 0.93, 0.89, 0.89},        // beside the root of the nose
    {0, -54, 24, 7, 0.99, 0.97, 0.965},     // above the lips
    {0, -84, 14, 3.5, 0.95, 0.92, 0.91},    // under the lower lip
    {62, -75, 22, 26, 0.975, 0.96, 0.955},  // side of the jaw
};

class Painter {
 public:
  Painter(const HeadShape& shape, const Identity& identity, int size)
      : shape_(shape), identity_(identity), size_(size), canvas_(std::size_t(size) * size) {
    dark_ = identity.hair_tone * 0.55F;
  }

  void ground() {
    over_texels(shape_, size_, [&](std::size_t texel, const Vec2& domain, const Vec2& front) {
      canvas_[texel] = ground_colour(domain, front);
    });
  }

  void brows() {
    Dice dice(identity_.texture_seed);
    static const FunctionCurve upper(brow_upper_edge());
    static const FunctionCurve lower(brow_lower_edge());
    const double first = upper.first_x();
    const double last = upper.last_x();
    for (const double side : {1.0, -1.0}) {
      for (int i = 0; i < 620; ++i) {
        const double s = dice();
        const double v = dice();
        if (dice() > 0.30 + 0.70 * smooth_step(-0.02, 0.22, s)) continue;  // thin at the inner end
        const double x = first - 0.8 + s * (last - first - 3.0);
        const double low = lower(x);
        const double high = upper(x);
        const Vec2 root(x, low + (0.06 + 0.80 * v) * (high - low));
        // Hairs stand up at the inner end and lie down outwards; the upper ones bend down.
        const double turn = smooth_step(0.0, 0.28, s);
        const double angle =
            (1.25 * (1.0 - turn) + turn * (0.50 - 0.55 * v - 0.42 * s)) + dice.between(-0.2, 0.2);
        double length = dice.between(3.2, 6.2) * (1.0 - 0.35 * s);
        const Vec2 along(std::cos(angle), std::sin(angle));
        // No hair leaves the brow by more than a little.
        const double room =
            (upper(x + length * along.x()) + 0.3 - root.y()) / std::max(0.05, along.y());
        if (along.y() > 0.0) length = std::min(length, std::max(1.5, room));
        stroke(
            side, {root, along, length, 0.26 * (1.0 - 0.3 * s), dice.between(0.25, 0.65)}, dark_);
      }
    }
  }

  void lashes() {
    Dice dice(identity_.texture_seed + 17U);
    const Colour black = identity_.hair_tone * 0.35F;
    for (const double side : {1.0, -1.0}) {
      for (int i = 0; i < 150; ++i) {
        const double s = dice.between(0.06, 1.0);
        const double angle = 2.0 - 1.55 * s + dice.between(-0.25, 0.25);
        stroke(side,
               {lid_margin(s, +1),
                {std::cos(angle), std::sin(angle)},
                dice.between(0.9, 1.9) * (0.6 + 0.6 * s),
                0.20,
                dice.between(0.35, 0.7)},
               black);
      }
      for (int i = 0; i < 70; ++i) {
        const double s = dice.between(0.15, 0.97);
        const double angle = -(2.0 - 1.4 * s) + dice.between(-0.25, 0.25);
        stroke(side,
               {lid_margin(s, -1),
                {std::cos(angle), std::sin(angle)},
                dice.between(0.8, 1.7),
                0.13,
                dice.between(0.15, 0.4)},
               black);
      }
    }
  }

  // Short thin hairs in front of the hairline, so that it does not look like the rim of a cap.
  void fringe() {
    Dice dice(identity_.texture_seed + 31U);
    for (int i = 0; i < 1500; ++i) {
      const double x = dice.between(-98.0, 98.0);
      const double slope =
          0.5 * (shape_.hairline(std::abs(x) + 1.0) - shape_.hairline(std::abs(x) - 1.0));
      const double below = 6.0 * dice() * dice();
      const Vec2 root(x, shape_.hairline(std::abs(x)) + 2.5 - below * std::hypot(1.0, slope));
      const Vec2 along = (root - Vec2(0.0, 5.0)).normalized();
      const double turn = dice.between(-0.35, 0.35);
      const Vec2 turned(std::cos(turn) * along.x() - std::sin(turn) * along.y(),
                        std::sin(turn) * along.x() + std::cos(turn) * along.y());
      const double length = dice.between(3.0, 9.0);
      const double opacity = dice.between(0.08, 0.34);
      for (double t = 0.0; t < length; t += 0.3) {
        dab(root + t * turned, 0.16, opacity * std::min(1.0, 0.3 + t / 4.0), identity_.hair_tone);
      }
    }
  }

  void freckles() {
    Dice dice(identity_.texture_seed + 99U);
    for (int i = 0; i < 260; ++i) {
      const Vec2 at(dice.between(-75.0, 75.0), dice.between(-115.0, 65.0));
      const double across = bump((at.y() + 18.0) / 28.0);
      if (dice() > 0.15 + 0.85 * across) continue;
      const Colour shade = identity_.skin_tone.cwiseProduct(Colour(0.72F, 0.56F, 0.46F));
      dab(at, dice.between(0.35, 0.9), dice.between(0.04, 0.22), shade);
    }
  }

  Texture finish() const {
    Texture texture;
    texture.width = size_;
    texture.height = size_;
    texture.rgb.reserve(canvas_.size() * 3);
    for (const Colour& c : canvas_) {
      for (int k = 0; k < 3; ++k) {
        const float level = std::clamp(c[k], 0.0F, 1.0F) * 255.0F + 0.5F;
        texture.rgb.push_back(static_cast<std::uint8_t>(level));
      }
    }
    return texture;
  }

 private:
  Colour skin_colour(const Vec2& domain, const Vec2& front) const {
    Colour colour = identity_.skin_tone;
    const std::uint32_t seed = identity_.texture_seed;
    const double x = front.x();
    for (const Spot& spot : kSpots) {
      const double dx = (x - spot.x) / spot.radius_x;
      const double dy = (front.y() - spot.y) / spot.radius_y;
      const double far = dx * dx + dy * dy;
      if (far > 8.0) continue;
      const float w = static_cast<float>(std::exp(-far));
      colour = colour.cwiseProduct(Colour(1.0F + w * static_cast<float>(spot.red - 1.0),
                                          1.0F + w * static_cast<float>(spot.green - 1.0),
                                          1.0F + w * static_cast<float>(spot.blue - 1.0)));
    }
    const double blotch = noise(domain.x() / 14.0, domain.y() / 14.0, seed) +
                          0.6 * noise(domain.x() / 5.0, domain.y() / 5.0, seed + 1);
    const double pore = noise(domain.x() / 1.1, domain.y() / 1.1, seed + 2) +
                        noise(domain.x() / 0.6, domain.y() / 0.6, seed + 3);
    colour = colour.cwiseProduct(Colour(static_cast<float>(1.0 + 0.010 * blotch + 0.013 * pore),
                                        static_cast<float>(1.0 + 0.020 * blotch + 0.017 * pore),
                                        static_cast<float>(1.0 + 0.020 * blotch + 0.017 * pore)));
    return colour;
  }

  // The shadow of a beard and its short hairs: jaw, chin and upper lip.
  void stubble(const Vec2& domain, const Vec2& front, Colour& colour) const {
    const double x = front.x();
    const double y = front.y();
    // Up to a line from the corner of the mouth to the ear, down to the throat.
    const double cheek = smooth_step(7.0, -7.0, y - (-66.0 + 0.55 * std::max(0.0, x - 26.0)));
    const double lip = smooth_step(30.0, 24.0, x) * smooth_step(-49.0, -54.0, y);
    const double throat = smooth_step(-138.0, -118.0, domain.y());
    const double back = smooth_step(112.0, 98.0, std::abs(domain.x()));
    const double grows = identity_.stubble * std::max(cheek, lip) * throat * back;
    if (grows <= 0.0) return;
    const std::uint32_t seed = identity_.texture_seed;
    const double patchy = 0.85 + 0.15 * noise(domain.x() / 9.0, domain.y() / 9.0, seed + 61);
    const double hairs = noise(domain.x() / 0.8, domain.y() / 1.1, seed + 62) +
                         0.7 * noise(domain.x() / 0.5, domain.y() / 0.7, seed + 63);
    const Colour shadow = colour.cwiseProduct(Colour(0.70F, 0.72F, 0.76F));
    colour = mix(colour, shadow, 0.75 * grows * patchy);
    colour = mix(colour, dark_, 0.42 * grows * patchy * smooth_step(0.0, 1.0, hairs));
  }

  void lips(const Vec2& domain, const Vec2& front, Colour& colour) const {
    static const FunctionCurve line(mouth_line());
    static const FunctionCurve upper(upper_lip_border());
    static const FunctionCurve lower(lower_lip_border());
    const double x = front.x();
    if (x > 34.0 || front.y() > -50.0 || front.y() < -90.0) return;
    const double d = front.y() - line(x);
    const double height = d > 0.0 ? upper(x) - line(x) : line(x) - lower(x);
    const double out = std::abs(d) - height;
    const double red = smooth_step(1.0, -1.1, out) * smooth_step(26.6, 24.2, x);
    const double fine = noise(domain.x() / 0.7, domain.y() / 5.0, identity_.texture_seed + 5);
    Colour lip = identity_.skin_tone.cwiseProduct(d > 0.0 ? Colour(0.845F, 0.655F, 0.655F)
                                                          : Colour(0.91F, 0.72F, 0.715F));
    lip *= static_cast<float>(1.0 + 0.05 * fine);
    colour = mix(colour, lip, 0.92 * red);
    // Paler roll around the red, and the dark line between the lips.
    colour *=
        static_cast<float>(1.0 + 0.035 * bump((out - 1.6) / 1.0) * smooth_step(26.0, 22.0, x));
    const double slit = bump(d / 0.7) * smooth_step(27.4, 25.0, x);
    colour = mix(colour, identity_.skin_tone.cwiseProduct(Colour(0.36F, 0.17F, 0.17F)), 0.6 * slit);
    const double corner = bump(std::hypot((x - 26.3) / 2.6, d / 1.5));
    colour *= static_cast<float>(1.0 - 0.28 * corner);
  }

  void lid_colours(const Vec2& front, Colour& colour) const {
    const double s = (front.x() - 17.4) / (44.6 - 17.4);
    if (s < -0.2 || s > 1.3 || std::abs(front.y()) > 20.0) return;
    const double t = std::clamp(s, 0.0, 1.0);
    const double past = std::max({0.0, front.x() - 44.6, 17.4 - front.x()});
    const double above = std::hypot(front.y() - lid_margin(t, +1).y(), 1.6 * past);
    const double below = std::hypot(lid_margin(t, -1).y() - front.y(), 1.6 * past);
    const Colour lash = identity_.hair_tone * 0.45F;
    colour = mix(colour, lash, 0.85 * smooth_step(1.2, 0.3, above) * smooth_step(-0.05, 0.2, s));
    const Colour pink = identity_.skin_tone.cwiseProduct(Colour(0.93F, 0.74F, 0.72F));
    colour = mix(colour, pink, 0.7 * smooth_step(1.2, 0.3, below));
    colour = mix(colour, lash, 0.45 * bump((below - 1.3) / 0.8) * smooth_step(0.1, 0.6, s));
    // The crease.
    const double crease = front.y() - lid_margin(t, +1).y() - 5.6;
    colour *= static_cast<float>(1.0 - 0.20 * bump(crease / 1.1) * smooth_step(0.0, 0.3, s) *
                                           smooth_step(1.12, 0.75, s));
  }

  Colour ground_colour(const Vec2& domain, const Vec2& front) const {
    // Under thick hair almost nothing is seen of the skin.
    constexpr double kThick = 1.8;  // mm
    const double thick = shape_.hair_mm(domain);
    if (thick > kThick) return hair(domain, thick, identity_.skin_tone);
    Colour colour = skin_colour(domain, front);
    if (identity_.stubble > 0.0) stubble(domain, front, colour);
    const bool in_front = std::abs(domain.x()) < 75.0 && domain.y() < 60.0 && domain.y() > -120.0;
    if (in_front) {
      lips(domain, front, colour);
      lid_colours(front, colour);
      const Vec2 nostril = front - Vec2(6.6, -45.4);
      const double dark = bump(std::hypot(nostril.x() / 3.3, nostril.y() / 1.7));
      colour =
          mix(colour, identity_.skin_tone.cwiseProduct(Colour(0.20F, 0.10F, 0.09F)), 0.9 * dark);
      // Skin under the brow hairs.
      static const FunctionCurve upper(brow_upper_edge());
      static const FunctionCurve lower(brow_lower_edge());
      const double x = front.x();
      const double inside = std::min(upper(x) - front.y(), front.y() - lower(x));
      const double ends = smooth_step(8.5, 19.0, x) * smooth_step(55.0, 46.0, x);
      colour = mix(colour, dark_, 0.36 * smooth_step(-0.8, 2.2, inside) * ends);
    }
    return hair(domain, thick, colour);
  }

  Colour hair(const Vec2& domain, double thick, const Colour& skin) const {
    return hair_over_skin(identity_, domain, thick, skin);
  }

  // A tapering hair in the frontal picture, x >= 0.
  struct Hair {
    Vec2 root;
    Vec2 along;
    double length;
    double radius;
    double opacity;
  };

  // Drawn on one side.
  void stroke(double side, const Hair& hair, const Colour& colour) {
    const Vec2 a = shape_.domain_from_front(hair.root);
    const Vec2 b = shape_.domain_from_front(hair.root + hair.length * hair.along);
    const int steps = std::max(2, static_cast<int>(hair.length / 0.16));
    for (int i = 0; i <= steps; ++i) {
      const double t = static_cast<double>(i) / steps;
      Vec2 at = a + t * (b - a);
      at.x() *= side;
      dab(at, hair.radius * (1.0 - 0.6 * t), 0.45 * hair.opacity * (1.0 - 0.5 * t), colour);
    }
  }

  void dab(const Vec2& domain, double radius_mm, double opacity, const Colour& colour) {
    const Eigen::Vector2f uv = uv_from_domain(domain);
    const Eigen::Vector2f next = uv_from_domain(domain + Vec2(1.0, 0.0));
    const double texels_per_mm = static_cast<double>((next - uv).norm()) * size_;
    const double radius = std::max(0.7, radius_mm * texels_per_mm);
    const double thin = std::min(1.0, radius_mm * texels_per_mm / 0.7);
    const double cx = static_cast<double>(uv.x()) * size_ - 0.5;
    const double cy = static_cast<double>(uv.y()) * size_ - 0.5;
    const int reach = static_cast<int>(std::ceil(2.0 * radius));
    for (int j = -reach; j <= reach; ++j) {
      for (int i = -reach; i <= reach; ++i) {
        const int column = static_cast<int>(std::lround(cx)) + i;
        const int row = static_cast<int>(std::lround(cy)) + j;
        if (column < 0 || row < 0 || column >= size_ || row >= size_) continue;
        const double d2 = (column - cx) * (column - cx) + (row - cy) * (row - cy);
        Colour& texel = canvas_[std::size_t(row) * size_ + column];
        texel = mix(texel, colour, opacity * thin * std::exp(-d2 / (radius * radius)));
      }
    }
  }

  const HeadShape& shape_;
  const Identity& identity_;
  int size_;
  std::vector<Colour> canvas_;
  Colour dark_;
};

}  // namespace

Eigen::Vector2f uv_from_domain(const Vec2& domain_mm) {
  const double u = squeeze(domain_mm.x() / kHalfWidth);
  const double v = squeeze((kMiddleY - domain_mm.y()) / kHalfHeight);
  return {static_cast<float>(0.5 + 0.5 * u), static_cast<float>(0.5 + 0.5 * v)};
}

Vec2 domain_from_uv(const Eigen::Vector2f& uv) {
  return {kHalfWidth * stretch(2.0 * uv.x() - 1.0),
          kMiddleY - kHalfHeight * stretch(2.0 * uv.y() - 1.0)};
}

Eigen::Vector3f hair_over_skin(const Identity& identity,
                               const Vec2& domain,
                               double thick,
                               const Eigen::Vector3f& skin) {
  if (thick <= 0.0) return skin;
  // Strands run away from the face.
  const Vec2 from_face = domain - Vec2(0.0, 5.0);
  const double angle = std::atan2(from_face.x(), from_face.y());
  const double radius = from_face.norm();
  const std::uint32_t seed = identity.texture_seed;
  const double wave = angle + 0.03 * noise(radius / 30.0, 3.0 * angle, seed + 11);
  const double strand = 0.55 * noise(wave * 130.0, radius / 34.0, seed + 12) +
                        0.45 * noise(wave * 320.0, radius / 22.0, seed + 13);
  const double lock = noise(wave * 26.0, radius / 60.0, seed + 14);
  const double cover = smooth_step(0.10, 1.3, thick + 0.45 * strand * smooth_step(0.0, 0.4, thick));
  Colour colour =
      identity.hair_tone * static_cast<float>(std::max(0.15, 0.85 + 0.50 * strand + 0.22 * lock));
  return mix(skin, colour, 0.97 * cover);
}

void over_texels(const HeadShape& shape,
                 int size_px,
                 const std::function<void(std::size_t, const Vec2&, const Vec2&)>& paint) {
  const auto domain_of_texel = [&](int column, int row) {
    return domain_from_uv({(static_cast<float>(column) + 0.5F) / static_cast<float>(size_px),
                           (static_cast<float>(row) + 0.5F) / static_cast<float>(size_px)});
  };
  // The frontal picture is smooth over the texture: known on a grid, linear between.
  constexpr int kStep = 8;
  const int nodes = size_px / kStep + 2;
  std::vector<Vec2> grid;
  for (int j = 0; j < nodes; ++j) {
    for (int i = 0; i < nodes; ++i) {
      grid.push_back(shape.front_from_domain(domain_of_texel(i * kStep, j * kStep)));
    }
  }
  // The domain's x depends on the column only, its y on the row only.
  std::vector<double> x_of_column, y_of_row;
  for (int i = 0; i < size_px; ++i) {
    const Vec2 on_diagonal = domain_of_texel(i, i);
    x_of_column.push_back(on_diagonal.x());
    y_of_row.push_back(on_diagonal.y());
  }
  for (int row = 0; row < size_px; ++row) {
    for (int column = 0; column < size_px; ++column) {
      const Vec2* at = grid.data() + (row / kStep) * nodes + column / kStep;
      const double u = (column % kStep) / static_cast<double>(kStep);
      const double v = (row % kStep) / static_cast<double>(kStep);
      const Vec2 front =
          (1 - v) * ((1 - u) * at[0] + u * at[1]) + v * ((1 - u) * at[nodes] + u * at[nodes + 1]);
      paint(std::size_t(row) * size_px + column, Vec2(x_of_column[column], y_of_row[row]), front);
    }
  }
}

Texture paint_skin(const HeadShape& shape, const Identity& identity, int size_px) {
  Painter painter(shape, identity, size_px);
  painter.ground();
  painter.freckles();
  painter.fringe();
  painter.brows();
  painter.lashes();
  return painter.finish();
}

Eigen::Vector3f linear_from_srgb(const Eigen::Vector3f& srgb) {
  Eigen::Vector3f linear;
  for (int k = 0; k < 3; ++k) {
    const float c = srgb[k];
    linear[k] = c <= 0.04045F ? c / 12.92F : std::pow((c + 0.055F) / 1.055F, 2.4F);
  }
  return linear;
}

}  // namespace zygoma
