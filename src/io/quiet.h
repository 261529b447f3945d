// FFmpeg likes to talk to stderr about damaged files. What matters about a file reaches the user
// through our own messages, so the library is told to be silent.
#pragma once

namespace zygoma {

void silence_video_library();

}  // namespace zygoma
