// How much of the machine other programs took while we worked: a time on the wall says little
// without it.
#pragma once

namespace zygoma {

class LoadMeter {
 public:
  LoadMeter();  // measures from here on
  // Of all processors, in [0, 1]; what the host of a virtual machine gave to others counts. 0 where
  // the kernel does not say (/proc/stat).
  double share_of_others() const;

 private:
  double machine_busy_s_ = 0.0;
  double machine_total_s_ = 0.0;
  double own_s_ = 0.0;
};

}  // namespace zygoma
