#include "src/io/video_writer.h"

#include <cassert>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <string>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/imgutils.h>
#include <libavutil/opt.h>
#include <libswscale/swscale.h>
}

#include "src/base/check.h"
#include "src/io/av_handles.h"
#include "src/io/quiet.h"
#include "src/io/text.h"

namespace zygoma {
namespace {

constexpr int kTicksPerSecond = 90000;  // holds 24, 25, 30, 60 and 30000/1001 frames/s exactly

struct FreeScaler {
  void operator()(SwsContext* scaler) const { sws_freeContext(scaler); }
};
struct CloseContainer {
  void operator()(AVFormatContext* container) const {
    avio_closep(&container->pb);
    avformat_free_context(container);
  }
};

int even(int size) { return size + size % 2; }

std::string reason(int error) {
  char text[AV_ERROR_MAX_STRING_SIZE] = {};
  av_strerror(error, text, sizeof text);
  return text;
}

// What only a broken installation can cause; not the user's input.
void require_library(bool condition, const char* what) {
  if (!condition) throw std::runtime_error(std::string("FFmpeg: ") + what);
}

}  // namespace

struct VideoWriter::Impl {
  std::string path;
  std::string part_path;
  cv::Size size;       // as given
  cv::Size even_size;  // as written
  std::unique_ptr<AVFormatContext, CloseContainer> container;
  std::unique_ptr<AVCodecContext, FreeCodec> codec;
  std::unique_ptr<AVFrame, FreeFrame> frame;
  std::unique_ptr<AVPacket, FreePacket> packet;
  std::unique_ptr<SwsContext, FreeScaler> scaler;
  AVStream* stream = nullptr;
  cv::Mat padded;
  std::int64_t last_pts = -1;
  std::int64_t last_step = 0;
  bool part_exists = false;

  ~Impl() {
    container.reset();
    if (part_exists) std::remove(part_path.c_str());
  }

  void need(int status, const char* what) const {
    require(status >= 0, path + ": " + what + " (" + reason(status) + ")");
  }

  void open_encoder(double average_frames_per_s, const VideoWriterOptions& options) {
    const AVCodec* encoder = avcodec_find_encoder_by_name("libx264");
    require_library(encoder != nullptr, "the encoder libx264 is not installed");
    codec.reset(avcodec_alloc_context3(encoder));
    require_library(codec != nullptr, "out of memory");
    codec->width = even_size.width;
    codec->height = even_size.height;
    codec->pix_fmt = AV_PIX_FMT_YUV420P;
    codec->time_base = {1, kTicksPerSecond};
    codec->framerate = av_d2q(average_frames_per_s, 100000);
    codec->thread_count = options.num_threads;
    // The conversion below follows BT.601 with limited range; players must know.
    codec->colorspace = AVCOL_SPC_SMPTE170M;
    codec->color_range = AVCOL_RANGE_MPEG;
    codec->color_primaries = AVCOL_PRI_BT709;
    codec->color_trc = AVCOL_TRC_BT709;
    if ((container->oformat->flags & AVFMT_GLOBALHEADER) != 0) {
      codec->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
    }
    av_opt_set(codec->priv_data, "preset", options.preset.c_str(), 0);
    av_opt_set_int(codec->priv_data, "crf", options.constant_rate_factor, 0);
    require(avcodec_open2(codec.get(), encoder, nullptr) >= 0,
            path + ": no H.264 video of " + std::to_string(size.width) + " x " +
                std::to_string(size.height) + " pixels can be made with preset " + options.preset);
  }

  void open_container(double average_frames_per_s) {
    stream = avformat_new_stream(container.get(), nullptr);
    require_library(stream != nullptr, "out of memory");
    stream->time_base = codec->time_base;
    stream->avg_frame_rate = av_d2q(average_frames_per_s, 100000);
    need(avcodec_parameters_from_context(stream->codecpar, codec.get()), "cannot be set up");
    need(avio_open(&container->pb, part_path.c_str(), AVIO_FLAG_WRITE), "cannot be written");
    part_exists = true;
    AVDictionary* muxer = nullptr;
    av_dict_set(&muxer, "movflags", "+faststart", 0);  // playable while it is still loading
    av_dict_set_int(&muxer, "video_track_timescale", kTicksPerSecond, 0);
    const int status = avformat_write_header(container.get(), &muxer);
    av_dict_free(&muxer);
    need(status, "cannot be written");
  }

  void open_picture() {
    frame.reset(av_frame_alloc());
    packet.reset(av_packet_alloc());
    require_library(frame != nullptr && packet != nullptr, "out of memory");
    frame->format = codec->pix_fmt;
    frame->width = codec->width;
    frame->height = codec->height;
    require_library(av_frame_get_buffer(frame.get(), 0) >= 0, "out of memory");
    scaler.reset(sws_getContext(codec->width,
                                codec->height,
                                AV_PIX_FMT_BGR24,
                                codec->width,
                                codec->height,
                                codec->pix_fmt,
                                SWS_POINT,
                                nullptr,
                                nullptr,
                                nullptr));
    require_library(scaler != nullptr, "no colour conversion");
  }

  // Hands a picture (or nullptr: no more will come) to the encoder and what it gives back to the
  // file.
  void encode(const AVFrame* picture) {
    need(avcodec_send_frame(codec.get(), picture), "cannot be encoded");
    for (;;) {
      const int status = avcodec_receive_packet(codec.get(), packet.get());
      if (status == AVERROR(EAGAIN) || status == AVERROR_EOF) return;
      need(status, "cannot be encoded");
      packet->stream_index = stream->index;
      // Matters for the last packet only: the others last until the next one begins.
      packet->duration = last_step;
      av_packet_rescale_ts(packet.get(), codec->time_base, stream->time_base);
      need(av_interleaved_write_frame(container.get(), packet.get()), "cannot be written");
    }
  }

  const cv::Mat& with_even_size(const cv::Mat& bgr) {
    if (size == even_size) return bgr;
    cv::copyMakeBorder(bgr,
                       padded,
                       0,
                       even_size.height - size.height,
                       0,
                       even_size.width - size.width,
                       cv::BORDER_REPLICATE);
    return padded;
  }
};

VideoWriter::VideoWriter(const std::string& path,
                         int width_px,
                         int height_px,
                         double average_frames_per_s,
                         const VideoWriterOptions& options)
    : impl_(std::make_unique<Impl>()) {
  assert(width_px > 0 && height_px > 0 && average_frames_per_s > 0);
  silence_video_library();
  impl_->path = path;
  impl_->part_path = std::filesystem::absolute(path).string() + ".part";
  impl_->size = {width_px, height_px};
  impl_->even_size = {even(width_px), even(height_px)};
  impl_->last_step = std::llround(kTicksPerSecond / average_frames_per_s);

  std::error_code ignored;
  require(!std::filesystem::is_directory(path, ignored),
          path + ": is a folder, expected a video file that can be written");
  AVFormatContext* container = nullptr;
  const int status =
      avformat_alloc_output_context2(&container, nullptr, "mp4", impl_->part_path.c_str());
  require_library(status >= 0 && container != nullptr, "MP4 files cannot be written");
  impl_->container.reset(container);
  impl_->open_encoder(average_frames_per_s, options);
  impl_->open_container(average_frames_per_s);
  impl_->open_picture();
}

VideoWriter::~VideoWriter() = default;

void VideoWriter::write(const cv::Mat& bgr, double time_s) {
  assert(bgr.type() == CV_8UC3 && bgr.size() == impl_->size);
  const std::int64_t pts = std::llround(time_s * kTicksPerSecond);
  assert(pts > impl_->last_pts);
  if (impl_->last_pts >= 0) impl_->last_step = pts - impl_->last_pts;
  impl_->last_pts = pts;

  AVFrame* frame = impl_->frame.get();
  require_library(av_frame_make_writable(frame) >= 0, "out of memory");
  const cv::Mat& picture = impl_->with_even_size(bgr);
  const std::uint8_t* const source[] = {picture.data};
  const int source_stride[] = {static_cast<int>(picture.step)};
  sws_scale(
      impl_->scaler.get(), source, source_stride, 0, picture.rows, frame->data, frame->linesize);
  frame->pts = pts;
  impl_->encode(frame);
}

void VideoWriter::finish() {
  impl_->encode(nullptr);
  impl_->need(av_write_trailer(impl_->container.get()), "cannot be written completely");
  impl_->need(avio_closep(&impl_->container->pb), "cannot be written completely");
  impl_->container.reset();
  errno = 0;
  const bool renamed = std::rename(impl_->part_path.c_str(), impl_->path.c_str()) == 0;
  require(renamed, impl_->path + ": cannot be put in place (" + system_reason(errno) + ")");
  impl_->part_exists = false;
}

}  // namespace zygoma
