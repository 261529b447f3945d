#include "src/io/quiet.h"

#include <cstdarg>

extern "C" {
#include <libavutil/log.h>
}

namespace zygoma {

void silence_video_library() {
  av_log_set_callback([](void*, int, const char*, va_list) {});
}

}  // namespace zygoma
