// Owners of what FFmpeg's libraries hand out, shared by reader and writer. They hold a container
// differently (one opens it, one makes it), so that owner is each one's own.
#pragma once

struct AVCodecContext;
struct AVFrame;
struct AVPacket;

namespace zygoma {

struct FreeCodec {
  void operator()(AVCodecContext* codec) const;
};
struct FreeFrame {
  void operator()(AVFrame* frame) const;
};
struct FreePacket {
  void operator()(AVPacket* packet) const;
};

}  // namespace zygoma
