#include "src/io/video_reader.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <new>
#include <opencv2/core.hpp>
#include <utility>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/display.h>
#include <libavutil/time.h>
#include <libswscale/swscale.h>
}

#include "src/base/check.h"
#include "src/io/av_handles.h"
#include "src/io/quiet.h"
#include "src/io/video_clock.h"

namespace zygoma {
namespace {

constexpr double kFallbackFramesPerSecond = 30.0;
constexpr double kLargestCredibleRate = 1000.0;
constexpr double kLargestCredibleCount = 1e8;
// How long a camera may be silent: ten seconds.
constexpr unsigned kWait_us = 2000;
constexpr int kMostWaits = 5000;
constexpr double kNoStamp = std::numeric_limits<double>::quiet_NaN();

// FFmpeg draws text files whose name says so (.txt, .nfo) as pictures of a terminal.
bool is_text_art(AVCodecID codec) {
  return codec == AV_CODEC_ID_ANSI || codec == AV_CODEC_ID_BINTEXT || codec == AV_CODEC_ID_XBIN ||
         codec == AV_CODEC_ID_IDF;
}

const std::int32_t* display_matrix(const AVStream& stream) {
#if LIBAVFORMAT_VERSION_INT >= AV_VERSION_INT(60, 15, 100)
  const AVPacketSideData* data = av_packet_side_data_get(stream.codecpar->coded_side_data,
                                                         stream.codecpar->nb_coded_side_data,
                                                         AV_PKT_DATA_DISPLAYMATRIX);
  const std::uint8_t* bytes = data == nullptr ? nullptr : data->data;
#else
  const std::uint8_t* bytes = av_stream_get_side_data(&stream, AV_PKT_DATA_DISPLAYMATRIX, nullptr);
#endif
  return reinterpret_cast<const std::int32_t*>(bytes);
}

// Clockwise, one of 0, 90, 180, 270.
int rotation_tag_deg(const AVStream& stream) {
  const std::int32_t* matrix = display_matrix(stream);
  const double counter_clockwise_deg = matrix == nullptr ? 0.0 : av_display_rotation_get(matrix);
  if (!std::isfinite(counter_clockwise_deg)) return 0;
  const int quarter_turns = static_cast<int>(std::lround(-counter_clockwise_deg / 90.0));
  return (quarter_turns % 4 + 4) % 4 * 90;
}

double average_rate(AVFormatContext* container, AVStream* stream) {
  double rate = av_q2d(stream->avg_frame_rate);
  if (!(rate > 0.0)) rate = av_q2d(av_guess_frame_rate(container, stream, nullptr));
  const bool credible = std::isfinite(rate) && rate > 0.0 && rate <= kLargestCredibleRate;
  return credible ? rate : kFallbackFramesPerSecond;
}

int about_num_frames(const AVFormatContext& container, const AVStream& stream, double rate) {
  double count = static_cast<double>(stream.nb_frames);
  if (count <= 0 && stream.duration > 0) {
    count = static_cast<double>(stream.duration) * av_q2d(stream.time_base) * rate;
  }
  if (count <= 0 && container.duration > 0) {
    count = static_cast<double>(container.duration) / AV_TIME_BASE * rate;
  }
  return count > 0 && count < kLargestCredibleCount ? static_cast<int>(std::lround(count)) : 0;
}

// The pictures of the first video stream, one after the other, as they are stored.
class Decoder {
 public:
  // False when there is nothing in it that can be decoded.
  bool open(OpenedSource source, bool is_camera) {
    container_ = std::move(source.container);
    num_pictures_ = source.num_pictures;
    is_live_ = is_camera;
    // A camera has said all there is to know; looking at its pictures would cost the first ones.
    if (!is_camera && avformat_find_stream_info(container_.get(), nullptr) < 0) return false;
    return open_stream();
  }

  // The next picture, or nullptr at the end. Damaged stretches are passed over.
  const AVFrame* next() {
    for (;;) {
      av_frame_unref(frame_.get());
      const int status = avcodec_receive_frame(codec_.get(), frame_.get());
      if (status == 0) return frame_.get();
      if (status == AVERROR_EOF) return nullptr;
      if (!feed()) return nullptr;
    }
  }

  // Of the last picture, s; NaN if the file does not say.
  double stamp_s() const {
    const bool has_stamps = (container_->iformat->flags & AVFMT_NOTIMESTAMPS) == 0;
    const std::int64_t stamp = frame_->best_effort_timestamp;
    if (!has_stamps || stamp == AV_NOPTS_VALUE) return kNoStamp;
    return static_cast<double>(stamp) * av_q2d(stream_->time_base);
  }

  AVFormatContext* container() const { return container_.get(); }
  AVStream* stream() const { return stream_; }
  int num_pictures() const { return num_pictures_; }

  // Asked while a camera has no picture yet; true ends the reading.
  StopQuestion stop;

 private:
  bool open_stream() {
    const AVCodec* decoder = nullptr;
    const int index =
        av_find_best_stream(container_.get(), AVMEDIA_TYPE_VIDEO, -1, -1, &decoder, 0);
    if (index < 0 || decoder == nullptr || is_text_art(decoder->id)) return false;
    stream_ = container_->streams[index];
    if ((stream_->disposition & AV_DISPOSITION_ATTACHED_PIC) != 0) return false;  // cover of a song
    for (unsigned i = 0; i < container_->nb_streams; ++i) {
      if (container_->streams[i] != stream_) container_->streams[i]->discard = AVDISCARD_ALL;
    }
    codec_.reset(avcodec_alloc_context3(decoder));
    frame_.reset(av_frame_alloc());
    packet_.reset(av_packet_alloc());
    if (!codec_ || !frame_ || !packet_) throw std::bad_alloc();
    if (avcodec_parameters_to_context(codec_.get(), stream_->codecpar) < 0) return false;
    codec_->pkt_timebase = stream_->time_base;
    codec_->thread_count = 0;  // as many as there are cores; the pictures are the same
    return avcodec_open2(codec_.get(), decoder, nullptr) >= 0;
  }

  // Hands the decoder its next packet, or the news that there is none. False when it has had that
  // news before.
  bool feed() {
    if (drained_) return false;
    while (read_packet()) {
      const bool ours = packet_->stream_index == stream_->index;
      if (ours) avcodec_send_packet(codec_.get(), packet_.get());  // damaged ones are its business
      av_packet_unref(packet_.get());
      if (ours) return true;
    }
    drained_ = true;
    avcodec_send_packet(codec_.get(), nullptr);
    return true;
  }

  // A camera without a picture is asked again until it has one, for some seconds.
  bool read_packet() {
    for (int waits = 0;; ++waits) {
      const int status = av_read_frame(container_.get(), packet_.get());
      if (status != AVERROR(EAGAIN) || !is_live_) return status >= 0;
      if (waits == kMostWaits || (stop && stop())) return false;
      av_usleep(kWait_us);
    }
  }

  std::unique_ptr<AVFormatContext, CloseContainer> container_;
  std::unique_ptr<AVCodecContext, FreeCodec> codec_;
  std::unique_ptr<AVFrame, FreeFrame> frame_;
  std::unique_ptr<AVPacket, FreePacket> packet_;
  AVStream* stream_ = nullptr;
  int num_pictures_ = 0;  // 0: not known
  bool is_live_ = false;
  bool drained_ = false;
};

// Decoded pictures to BGR of one size, which is that of the first picture.
class ColourConverter {
 public:
  ~ColourConverter() { sws_freeContext(scaler_); }

  // False when this kind of picture cannot be converted. The result is valid until the next call.
  bool convert(const AVFrame& picture, cv::Mat& bgr) {
    if (!bgr_) allocate(picture.width, picture.height);
    if (!prepare(picture)) return false;
    sws_scale(
        scaler_, picture.data, picture.linesize, 0, picture.height, bgr_->data, bgr_->linesize);
    bgr = cv::Mat(bgr_->height, bgr_->width, CV_8UC3, bgr_->data[0], bgr_->linesize[0]);
    return true;
  }

 private:
  // Rows are padded, because the conversion writes whole vector registers.
  void allocate(int width, int height) {
    bgr_.reset(av_frame_alloc());
    if (!bgr_) throw std::bad_alloc();
    bgr_->width = width;
    bgr_->height = height;
    bgr_->format = AV_PIX_FMT_BGR24;
    if (av_frame_get_buffer(bgr_.get(), 0) < 0) throw std::bad_alloc();
  }

  // Pictures of a stream are alike as a rule; whatever changes on the way is followed.
  bool prepare(const AVFrame& picture) {
    SwsContext* scaler = sws_getCachedContext(scaler_,
                                              picture.width,
                                              picture.height,
                                              static_cast<AVPixelFormat>(picture.format),
                                              bgr_->width,
                                              bgr_->height,
                                              AV_PIX_FMT_BGR24,
                                              SWS_BICUBIC,
                                              nullptr,
                                              nullptr,
                                              nullptr);
    // By what it is for: a new one may have the address of the old one.
    const bool is_new = picture.format != format_ || picture.width != width_ ||
                        picture.height != height_ || picture.colorspace != colour_space_ ||
                        picture.color_range != colour_range_;
    scaler_ = scaler;
    format_ = picture.format;
    width_ = picture.width;
    height_ = picture.height;
    colour_space_ = picture.colorspace;
    colour_range_ = picture.color_range;
    if (scaler_ != nullptr && is_new) {
      constexpr int kUnity = 1 << 16;
      sws_setColorspaceDetails(scaler_,
                               sws_getCoefficients(colour_space_),
                               colour_range_ == AVCOL_RANGE_JPEG ? 1 : 0,
                               sws_getCoefficients(SWS_CS_DEFAULT),
                               1,
                               0,
                               kUnity,
                               kUnity);
    }
    return scaler_ != nullptr;
  }

  SwsContext* scaler_ = nullptr;
  int format_ = AV_PIX_FMT_NONE;
  int width_ = 0;
  int height_ = 0;
  AVColorSpace colour_space_ = AVCOL_SPC_UNSPECIFIED;
  AVColorRange colour_range_ = AVCOL_RANGE_UNSPECIFIED;
  std::unique_ptr<AVFrame, FreeFrame> bgr_;
};

// Another owner of the same pixels.
std::unique_ptr<AVFrame, FreeFrame> shared(const AVFrame& picture) {
  std::unique_ptr<AVFrame, FreeFrame> copy(av_frame_clone(&picture));
  if (!copy) throw std::bad_alloc();
  return copy;
}

Planes planes_of(const AVFrame& picture) {
  const std::shared_ptr<AVFrame> owner = shared(picture);
  const auto plane = [&](int i, int shrink) {
    return cv::Mat(owner->height / shrink,
                   owner->width / shrink,
                   CV_8U,
                   owner->data[i],
                   static_cast<size_t>(owner->linesize[i]));
  };
  return {plane(0, 1), plane(1, 2), plane(2, 2), owner};
}

void turn(const cv::Mat& stored, int rotation_deg, cv::Mat& shown) {
  switch (rotation_deg) {
    case 90:
      cv::rotate(stored, shown, cv::ROTATE_90_CLOCKWISE);
      break;
    case 180:
      cv::rotate(stored, shown, cv::ROTATE_180);
      break;
    case 270:
      cv::rotate(stored, shown, cv::ROTATE_90_COUNTERCLOCKWISE);
      break;
    default:
      stored.copyTo(shown);
  }
}

}  // namespace

struct VideoReader::Impl {
  Decoder decoder;
  ColourConverter converter;
  VideoInfo info;
  VideoClock clock{kFallbackFramesPerSecond};
  std::unique_ptr<AVFrame, FreeFrame> first;  // decoded by the constructor, for the first read
  double first_stamp_s = 0.0;
  int num_read = 0;
  bool at_end = false;
  bool is_numbered = false;  // pictures: their time is their number over a rate

  // Valid until the next call; null at the end.
  const AVFrame* next(double& stamp_s) {
    if (num_read == 0) {
      stamp_s = first_stamp_s;
      return first.get();
    }
    const AVFrame* picture = at_end ? nullptr : decoder.next();
    if (picture != nullptr) stamp_s = decoder.stamp_s();
    return picture;
  }

  bool convert(const AVFrame& picture, cv::Mat& image) {
    cv::Mat stored;
    if (!converter.convert(picture, stored)) return false;
    turn(stored, info.rotation_deg, image);
    return true;
  }

  bool has_planes(const AVFrame& picture) const {
    return picture.format == AV_PIX_FMT_YUV420P && picture.color_range != AVCOL_RANGE_JPEG &&
           info.rotation_deg == 0 && picture.width == info.width_px &&
           picture.height == info.height_px && picture.width % 2 == 0 && picture.height % 2 == 0;
  }

  // The next picture with its place in time; `deliver` takes the picture over and may fail.
  template <typename Deliver>
  bool read(Frame& frame, const Deliver& deliver) {
    double stamp_s = 0.0;
    const AVFrame* picture = next(stamp_s);
    if (picture == nullptr || !deliver(*picture)) {
      at_end = true;
      return false;
    }
    frame.index = num_read++;
    frame.time_s = clock.next(stamp_s);
    first.reset();
    return true;
  }

  void describe(const VideoSource& source) {
    AVStream* stream = decoder.stream();
    is_numbered = decoder.num_pictures() > 0;
    info.path = source.path;
    const bool rate_given = source.frames_per_s > 0.0 && !source.is_camera;
    info.average_frames_per_s =
        rate_given ? source.frames_per_s : average_rate(decoder.container(), stream);
    info.about_num_frames = decoder.num_pictures();
    if (!is_numbered && !source.is_camera) {
      info.about_num_frames =
          about_num_frames(*decoder.container(), *stream, info.average_frames_per_s);
    }
    info.rotation_deg = rotation_tag_deg(*stream);
    const double aspect =
        av_q2d(av_guess_sample_aspect_ratio(decoder.container(), stream, nullptr));
    if (std::isfinite(aspect) && aspect > 0.0) {
      info.pixel_aspect = info.rotation_deg % 180 == 0 ? aspect : 1.0 / aspect;
    }
  }
};

VideoReader::VideoReader(const VideoSource& source, const StopQuestion& stop)
    : impl_(std::make_unique<Impl>()) {
  silence_video_library();
  impl_->decoder.stop = stop;
  require(impl_->decoder.open(open_source(source), source.is_camera),
          source.path +
              ": cannot be read as a video (another kind of file, or cut off before its index)" +
              kExpectedVideo);
  impl_->describe(source);
  const AVFrame* first = impl_->decoder.next();
  cv::Mat shown;
  require(first != nullptr && impl_->convert(*first, shown),
          source.is_camera ? source.path + ": gives no picture, expected a camera that does"
                           : source.path + ": no picture in it can be decoded" + kExpectedVideo);
  impl_->first = shared(*first);
  impl_->first_stamp_s = impl_->decoder.stamp_s();
  impl_->info.width_px = shown.cols;
  impl_->info.height_px = shown.rows;
  impl_->clock = VideoClock(impl_->info.average_frames_per_s);
}

VideoReader::~VideoReader() = default;
VideoReader::VideoReader(VideoReader&&) noexcept = default;

const VideoInfo& VideoReader::info() const { return impl_->info; }

bool VideoReader::read(Frame& frame) {
  frame.planes = {};
  return impl_->read(frame,
                     [&](const AVFrame& picture) { return impl_->convert(picture, frame.image); });
}

bool VideoReader::read_planes(Frame& frame) {
  return impl_->read(frame, [&](const AVFrame& picture) {
    frame.planes = {};
    if (!impl_->has_planes(picture)) return impl_->convert(picture, frame.image);
    frame.image.release();
    frame.planes = planes_of(picture);
    return true;
  });
}

const std::vector<int>& VideoReader::repaired_timestamps() const { return impl_->clock.repaired(); }

bool VideoReader::has_time_stamps() const { return !impl_->is_numbered && impl_->clock.has_time(); }

bool VideoReader::ended_early() const {
  // Containers overstate by a few frames (Matroska: 122 for 120), so a little less is no sign.
  const int claim = impl_->info.about_num_frames;
  const int allowed = std::max(5, claim / 50);
  return impl_->at_end && claim > 0 && impl_->num_read < claim - allowed;
}

}  // namespace zygoma
