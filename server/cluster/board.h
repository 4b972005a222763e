// Board: what the servers of a cluster share: keys with compare-and-set, and messages by subject.
#pragma once

#include "shared/core/result.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace zoned::cluster {

enum class BoardFault : std::uint8_t {
    kChanged,      ///< the key has another revision: nothing was written
    kUnknown,      ///< no answer in time: it may have been written, now or later
    kUnreachable,  ///< nothing was sent
};

struct BoardError {
    BoardFault fault = BoardFault::kUnreachable;
    std::string text;
};

template <class T>
using BoardResult = core::Result<T, BoardError>;

/// Revisions ascend over all keys of a board, and no two writes have the same: a revision serves as
/// a fencing number.
struct BoardEntry {
    std::string value;
    std::uint64_t revision = 0;
};

/// Messages come until it is destroyed.
class BoardSubscription {
  public:
    BoardSubscription() = default;
    BoardSubscription(const BoardSubscription&) = delete;
    BoardSubscription& operator=(const BoardSubscription&) = delete;
    virtual ~BoardSubscription() = default;
};

/// Keys and subjects consist of letters, digits, '-', '_', and '.' between parts. All calls are
/// allowed from any thread; those that give a BoardResult wait for the answer, at most about
/// the board's patience. Nothing throws.
class Board {
  public:
    Board() = default;
    Board(const Board&) = delete;
    Board& operator=(const Board&) = delete;
    virtual ~Board() = default;

    /// None where the key was never written. May be older than the newest write of another server.
    virtual BoardResult<std::optional<BoardEntry>> get(const std::string& key) = 0;

    /// Writes where the key's revision is `expected` (0: it was never written); the new revision.
    virtual BoardResult<std::uint64_t> put_if(const std::string& key,
                                              std::uint64_t expected,
                                              const std::string& value) = 0;

    /// All keys that begin with `prefix` and a '.', in no order.
    virtual BoardResult<std::vector<std::pair<std::string, BoardEntry>>> list(
        const std::string& prefix) = 0;

    /// To all that hear the subject now; lost where nobody does, or the way is down.
    virtual void publish(const std::string& subject, const std::string& bytes) = 0;

    /// `handler` is called on a thread of the board, one message at a time. Null where the
    /// board is closed.
    virtual std::unique_ptr<BoardSubscription> subscribe(
        const std::string& subject,
        std::function<void(const std::string& bytes)> handler) = 0;

    /// Whether the way to the board is up, as far as is known.
    [[nodiscard]] virtual bool connected() const = 0;
};

}  // namespace zoned::cluster
