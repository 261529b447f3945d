#include "src/io/rotation_tag.h"

#include <cmath>
#include <cstdint>

extern "C" {
#include <libavformat/avformat.h>
#include <libavutil/display.h>
}

namespace zygoma {
namespace {

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

int clockwise_deg(const AVStream& stream) {
  const std::int32_t* matrix = display_matrix(stream);
  const double counter_clockwise_deg = matrix == nullptr ? 0.0 : av_display_rotation_get(matrix);
  if (!std::isfinite(counter_clockwise_deg)) return 0;
  const int quarter_turns = static_cast<int>(std::lround(-counter_clockwise_deg / 90.0));
  return (quarter_turns % 4 + 4) % 4 * 90;
}

}  // namespace

int rotation_tag_deg(const std::string& path) {
  AVFormatContext* container = nullptr;
  if (avformat_open_input(&container, path.c_str(), nullptr, nullptr) < 0) return 0;
  int rotation_deg = 0;
  for (unsigned i = 0; i < container->nb_streams; ++i) {
    const AVStream& stream = *container->streams[i];
    if (stream.codecpar->codec_type != AVMEDIA_TYPE_VIDEO) continue;
    rotation_deg = clockwise_deg(stream);
    break;  // the first one is what is read
  }
  avformat_close_input(&container);
  return rotation_deg;
}

}  // namespace zygoma
