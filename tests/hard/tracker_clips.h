// Clips with known truth for the hard cases of the tracker: performers rendered once per program,
// what can happen to their pictures, and how far a track is from the truth.
//
// Distances are in chart pixels (64 to the distance between the eyes), so that they mean the same
// in every clip. The distance of two contours is the mean distance from the nodes of each to the
// line of the other: where along its feature a node stands does not count.
#pragma once

#include <cstdint>
#include <functional>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "tracker/contour_set.h"
#include "tracker/frame.h"
#include "tracker/second_look.h"
#include "tracker/tracker.h"

namespace zygoma::hard {

struct Clip {
  std::vector<Frame> frames;
  std::vector<ContourSet> truth;
  double chart_px = 1.0;  // one chart pixel in pixels of the picture, in the first frame
};

struct Track {
  std::vector<ContourSet> sets;  // one per frame
  std::vector<bool> face_found;
};
// Renders a performer, or returns the clip made before.
const Clip& performer(std::uint32_t seed,
                      const std::string& schedule = "mixed",
                      double duration_s = 6.0,
                      double frames_per_s = 25.0);
// The one most cases look at: brow raise, smile, frown, surprise, speech in six seconds.
const Clip& usual_performer();
// The same frames tracked undisturbed.
const Track& usual_track();
Clip part_of(const Clip& clip, size_t first, size_t count);

using PictureChange = std::function<cv::Mat(size_t frame, const cv::Mat& picture)>;
std::vector<Frame> changed(const std::vector<Frame>& frames, const PictureChange& change);

cv::Mat blurred(const cv::Mat& picture, double sigma_px);
cv::Mat motion_blurred(const cv::Mat& picture, int length_px);
cv::Mat noisy(const cv::Mat& picture, double sigma, std::uint64_t seed);
cv::Mat jpeg(const cv::Mat& picture, int quality);
cv::Mat exposed(const cv::Mat& picture, double gain);
cv::Mat with_gamma(const cv::Mat& picture, double gamma);
// A textured rectangle in the colour of the face's skin, its middle at `middle_px`.
cv::Mat with_hand(const cv::Mat& picture, const Point2& middle_px, const cv::Size& size);
// Shows the picture moved by q = matrix p; its border repeats.
cv::Mat moved(const cv::Mat& picture, const Similarity& motion);

Track track(const std::vector<Frame>& frames, const TrackerOptions& options = {});

struct LookedAt {
  std::vector<ContourSet> contours;
  std::vector<std::optional<Similarity>> heads;
};
// Every stretch of them followed twice.
LookedAt track_with_second_looks(const std::vector<Frame>& frames,
                                 const SecondLookOptions& options);

double distance_px(const std::vector<Point2>& a, const std::vector<Point2>& b);
// Of one contour in chart pixels; NaN when either is lost.
double distance(const Contour& a, const Contour& b, double chart_px);
// Mean over all contours that are visible in both, NaN if there are none.
double mean_distance(const ContourSet& a, const ContourSet& b, double chart_px);
double mean_confidence(const ContourSet& set);
Point2 middle_of(const Contour& contour);
// The contours as seen after the picture has moved.
ContourSet moved(const ContourSet& set, const Similarity& motion);

}  // namespace zygoma::hard
