// StageRun: the side that did a stage's work, and a flag for the one time a device was given up.
#pragma once

#include <string>

namespace zoned::compute {

/// The caller of a stage reads and logs it. The work is done either way.
struct StageRun {
    bool on_device = false;
    std::string fault;  ///< why the device was given up, in that run only; else empty
};

}  // namespace zoned::compute
