// PlainLog: the log of the PlainRules that this test program is linked with.
#pragma once

#include "tests/scenario/plain_rules.h"

#include <memory>

namespace zoned {

std::shared_ptr<scenario::PlainLog>& plain_log();

}  // namespace zoned
