// Ctrl-C (SIGINT) and SIGTERM as an answer to the stop question: the first one asks the work to
// stop between two units and keep what it has, the second one ends the program at once.
#pragma once

namespace zygoma {

void install_stop_signals();
bool stop_was_requested();

}  // namespace zygoma
