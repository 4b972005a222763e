// DoubtfulBoard: a board whose answers get lost on demand.
#pragma once

#include "server/cluster/board.h"

#include <memory>
#include <utility>

namespace zoned::cluster::test {

class DoubtfulBoard final : public Board {
  public:
    enum class Mood {
        kGood,
        kCut,         ///< nothing gets there
        kLosesAnswer  ///< writes are done, and their answers are lost
    };

    explicit DoubtfulBoard(std::unique_ptr<Board> behind) : behind_(std::move(behind)) {}

    BoardResult<std::optional<BoardEntry>> get(const std::string& key) override {
        if (mood == Mood::kCut) {
            return BoardResult<std::optional<BoardEntry>>::failure(
                {BoardFault::kUnreachable, "cut"});
        }
        return stale ? BoardResult<std::optional<BoardEntry>>(stale) : behind_->get(key);
    }

    BoardResult<std::uint64_t> put_if(const std::string& key,
                                      std::uint64_t expected,
                                      const std::string& value) override {
        ++writes;
        if (mood == Mood::kCut) {
            return BoardResult<std::uint64_t>::failure({BoardFault::kUnreachable, "cut"});
        }
        auto done = behind_->put_if(key, expected, value);
        if (mood == Mood::kLosesAnswer) {
            return BoardResult<std::uint64_t>::failure({BoardFault::kUnknown, "no answer"});
        }
        return done;
    }

    BoardResult<std::vector<std::pair<std::string, BoardEntry>>> list(
        const std::string& prefix) override {
        return behind_->list(prefix);
    }

    void publish(const std::string& subject, const std::string& bytes) override {
        behind_->publish(subject, bytes);
    }

    std::unique_ptr<BoardSubscription> subscribe(
        const std::string& subject,
        std::function<void(const std::string&)> handler) override {
        return behind_->subscribe(subject, std::move(handler));
    }

    [[nodiscard]] bool connected() const override { return mood != Mood::kCut; }

    Mood mood = Mood::kGood;
    int writes = 0;
    std::optional<BoardEntry> stale;  ///< get() gives it, as a server that is behind

  private:
    std::unique_ptr<Board> behind_;
};

}  // namespace zoned::cluster::test
