// StageRun: which side did a stage's work, and the one time when a device was given up.
#pragma once

#include <string>

namespace zoned::compute {

/// Whoever runs a stage reads it; logging is the caller's. The work is done either way.
struct StageRun {
    bool on_device = false;
    std::string fault;  ///< why the device was given up, in that run only; else empty
};

}  // namespace zoned::compute
