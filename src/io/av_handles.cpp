#include "src/io/av_handles.h"

extern "C" {
#include <libavcodec/avcodec.h>
}

namespace zygoma {

void FreeCodec::operator()(AVCodecContext* codec) const { avcodec_free_context(&codec); }
void FreeFrame::operator()(AVFrame* frame) const { av_frame_free(&frame); }
void FreePacket::operator()(AVPacket* packet) const { av_packet_free(&packet); }

}  // namespace zygoma
