// The question long work asks between two units of work ("should I stop?"). Engines never read
// clocks, signals or keyboards themselves; whoever starts them answers.
#pragma once

#include <functional>

namespace zygoma {

using StopQuestion = std::function<bool()>;

}  // namespace zygoma
