#include "server/cluster/settled_write.h"

#include <utility>

namespace zoned::cluster {

SettledWrite::Outcome SettledWrite::attempt(Board& board) {
    auto written = board.put_if(key, expected, value);
    if (written.ok()) {
        revision = *written;
        return Outcome::kDone;
    }
    if (written.error().fault != BoardFault::kChanged) {
        trouble = written.error().text;
        return Outcome::kAgain;
    }
    auto found = board.get(key);
    if (!found.ok()) {
        trouble = found.error().text;
        return Outcome::kAgain;
    }
    if (!*found || (*found)->revision <= expected) {
        trouble = "reading " + key + ": the answer is older than the write";
        return Outcome::kAgain;
    }
    present = std::move(**found);
    if (present.value == value) {
        revision = present.revision;  // an attempt before this one, whose answer was lost
        return Outcome::kDone;
    }
    return Outcome::kOvertaken;
}

}  // namespace zoned::cluster
