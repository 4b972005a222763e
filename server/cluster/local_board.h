// LocalBoard: a board within one process, for a server that is alone in its realm, and for tests.
#pragma once

#include "server/cluster/board.h"

#include <memory>

namespace zoned::cluster {

/// Boards of one hub see the same keys and hear each other.
class LocalHub;

[[nodiscard]] std::shared_ptr<LocalHub> make_local_hub();
[[nodiscard]] std::unique_ptr<Board> make_local_board(std::shared_ptr<LocalHub> hub);

}  // namespace zoned::cluster
