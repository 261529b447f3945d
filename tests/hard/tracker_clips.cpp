#include "tests/hard/tracker_clips.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <tuple>

#include "src/synthetic/performer.h"
#include "tests/support/lines.h"
#include "tracker/face_chart.h"

namespace zygoma::hard {
namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

Clip render(std::uint32_t seed, const std::string& schedule, double duration_s, double rate) {
  PerformerOptions options;
  options.seed = seed;
  options.schedule = schedule;
  options.duration_s = duration_s;
  options.frames_per_s = rate;
  options.width_px = 480;
  options.num_surface_vertices = 300;
  Performer performer(options);
  Clip clip;
  Frame frame;
  Contractions contractions;
  ContourSet truth;
  while (performer.next(frame, contractions, truth)) {
    clip.frames.push_back(frame);
    clip.truth.push_back(truth);
  }
  Tracker tracker;
  tracker.track(clip.frames.front());
  if (tracker.head() != nullptr) clip.chart_px = tracker.head()->scale();
  return clip;
}

}  // namespace

const Clip& performer(std::uint32_t seed,
                      const std::string& schedule,
                      double duration_s,
                      double frames_per_s) {
  static std::map<std::tuple<std::uint32_t, std::string, double, double>, Clip> clips;
  const auto key = std::make_tuple(seed, schedule, duration_s, frames_per_s);
  const auto found = clips.find(key);
  if (found != clips.end()) return found->second;
  return clips[key] = render(seed, schedule, duration_s, frames_per_s);
}

const Clip& usual_performer() { return performer(1); }

const Track& usual_track() {
  static const Track made = track(usual_performer().frames);
  return made;
}

Clip part_of(const Clip& clip, size_t first, size_t count) {
  Clip part;
  part.chart_px = clip.chart_px;
  for (size_t i = first; i < std::min(first + count, clip.frames.size()); ++i) {
    part.frames.push_back(clip.frames[i]);
    part.truth.push_back(clip.truth[i]);
  }
  return part;
}

std::vector<Frame> changed(const std::vector<Frame>& frames, const PictureChange& change) {
  std::vector<Frame> out = frames;
  for (size_t i = 0; i < out.size(); ++i) out[i].image = change(i, frames[i].image);
  return out;
}

cv::Mat blurred(const cv::Mat& picture, double sigma_px) {
  cv::Mat out;
  cv::GaussianBlur(picture, out, cv::Size(), sigma_px);
  return out;
}

cv::Mat motion_blurred(const cv::Mat& picture, int length_px) {
  cv::Mat out;
  cv::blur(picture, out, cv::Size(length_px, 1));
  return out;
}

cv::Mat noisy(const cv::Mat& picture, double sigma, std::uint64_t seed) {
  cv::RNG random(0x5eed0000U + seed);
  cv::Mat noise(picture.size(), CV_MAKETYPE(CV_16S, picture.channels())), wide;
  random.fill(noise, cv::RNG::NORMAL, cv::Scalar::all(0.0), cv::Scalar::all(sigma));
  picture.convertTo(wide, noise.type());
  wide += noise;
  cv::Mat out;
  wide.convertTo(out, picture.type());
  return out;
}

cv::Mat jpeg(const cv::Mat& picture, int quality) {
  std::vector<unsigned char> bytes;
  cv::imencode(".jpg", picture, bytes, {cv::IMWRITE_JPEG_QUALITY, quality});
  return cv::imdecode(bytes, cv::IMREAD_UNCHANGED);
}

cv::Mat exposed(const cv::Mat& picture, double gain) {
  cv::Mat out;
  picture.convertTo(out, -1, gain);
  return out;
}

cv::Mat with_gamma(const cv::Mat& picture, double gamma) {
  cv::Mat table(1, 256, CV_8U), out;
  for (int v = 0; v < 256; ++v) {
    table.at<unsigned char>(v) =
        cv::saturate_cast<unsigned char>(255.0 * std::pow(v / 255.0, gamma));
  }
  cv::LUT(picture, table, out);
  return out;
}

cv::Mat with_hand(const cv::Mat& picture, const Point2& middle_px, const cv::Size& size) {
  cv::Mat out = picture.clone();
  const cv::Rect place = cv::Rect(static_cast<int>(middle_px.x()) - size.width / 2,
                                  static_cast<int>(middle_px.y()) - size.height / 2,
                                  size.width,
                                  size.height) &
                         cv::Rect(0, 0, picture.cols, picture.rows);
  if (place.empty()) return out;
  cv::Mat hand = out(place);
  // Skin with creases and nails: blurred noise over four bands.
  cv::Mat texture(hand.size(), CV_8UC3);
  cv::RNG random(77);
  random.fill(texture, cv::RNG::NORMAL, cv::Scalar(120, 145, 190), cv::Scalar::all(60));
  cv::GaussianBlur(texture, texture, cv::Size(), 2.5);
  for (int finger = 1; finger < 4; ++finger) {
    const int x = finger * texture.cols / 4;
    cv::line(texture, {x, 0}, {x, texture.rows}, cv::Scalar(70, 85, 120), 2, cv::LINE_AA);
  }
  texture.copyTo(hand);
  return out;
}

cv::Mat moved(const cv::Mat& picture, const Similarity& motion) {
  const cv::Matx23d matrix(
      motion.a, -motion.b, motion.shift.x(), motion.b, motion.a, motion.shift.y());
  cv::Mat out;
  cv::warpAffine(picture, out, matrix, picture.size(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return out;
}

Track track(const std::vector<Frame>& frames, const TrackerOptions& options) {
  Tracker tracker(options);
  Track out;
  for (const Frame& frame : frames) {
    out.sets.push_back(tracker.track(frame));
    out.face_found.push_back(tracker.report().face_found);
  }
  return out;
}

LookedAt track_with_second_looks(const std::vector<Frame>& frames,
                                 const SecondLookOptions& options) {
  Tracker tracker;
  SecondLook look(options);
  LookedAt out;
  for (const Frame& frame : frames) {
    out.contours.push_back(tracker.track(frame));
    const Similarity* head = tracker.head();
    out.heads.push_back(head ? std::optional(*head) : std::nullopt);
    look.add(frame);
    if (look.full()) look.look(tracker, out.contours, out.heads);
  }
  look.look(tracker, out.contours, out.heads);
  return out;
}

double distance_px(const std::vector<Point2>& a, const std::vector<Point2>& b) {
  double sum = 0.0;
  for (const Point2& p : a) sum += distance_to_line(p, b) / static_cast<double>(a.size());
  for (const Point2& p : b) sum += distance_to_line(p, a) / static_cast<double>(b.size());
  return 0.5 * sum;
}

double distance(const Contour& a, const Contour& b, double chart_px) {
  if (a.lost() || b.lost()) return kNothing;
  return distance_px(a.points_px, b.points_px) / chart_px;
}

double mean_distance(const ContourSet& a, const ContourSet& b, double chart_px) {
  double sum = 0.0;
  int count = 0;
  for (const Contour& contour : a.contours) {
    const Contour* other = b.visible(contour.name);
    if (contour.lost() || other == nullptr) continue;
    sum += distance(contour, *other, chart_px);
    ++count;
  }
  return count > 0 ? sum / count : kNothing;
}

double mean_confidence(const ContourSet& set) {
  double sum = 0.0;
  for (const Contour& contour : set.contours) sum += contour.confidence;
  return set.contours.empty() ? 0.0 : sum / static_cast<double>(set.contours.size());
}

Point2 middle_of(const Contour& contour) {
  Point2 sum = Point2::Zero();
  for (const Point2& p : contour.points_px) sum += p;
  return sum / static_cast<double>(contour.points_px.size());
}

ContourSet moved(const ContourSet& set, const Similarity& motion) {
  ContourSet out = set;
  for (Contour& contour : out.contours) {
    for (Point2& p : contour.points_px) p = motion.apply(p);
  }
  return out;
}

}  // namespace zygoma::hard
