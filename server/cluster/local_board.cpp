#include "server/cluster/local_board.h"

#include <map>
#include <mutex>
#include <set>

namespace zoned::cluster {

namespace {

struct LocalListener {
    std::string subject;
    std::function<void(const std::string&)> handler;
    std::recursive_mutex running;  // held while the handler runs; it may end its own subscription
    bool ended = false;
};

}  // namespace

class LocalHub {
  public:
    std::optional<BoardEntry> get(const std::string& key) {
        const std::lock_guard lock(mutex_);
        const auto it = entries_.find(key);
        return it == entries_.end() ? std::nullopt : std::optional(it->second);
    }

    BoardResult<std::uint64_t> put_if(const std::string& key,
                                      std::uint64_t expected,
                                      const std::string& value) {
        const std::lock_guard lock(mutex_);
        const auto it = entries_.find(key);
        const std::uint64_t present = it == entries_.end() ? 0 : it->second.revision;
        if (present != expected) {
            return BoardResult<std::uint64_t>::failure(
                {BoardFault::kChanged, key + " has another revision"});
        }
        entries_[key] = {value, ++revision_};
        return revision_;
    }

    std::vector<std::pair<std::string, BoardEntry>> list(const std::string& prefix) {
        const std::lock_guard lock(mutex_);
        const std::string begin = prefix + ".";
        std::vector<std::pair<std::string, BoardEntry>> out;
        for (auto it = entries_.lower_bound(begin);
             it != entries_.end() && it->first.compare(0, begin.size(), begin) == 0;
             ++it) {
            out.emplace_back(*it);
        }
        return out;
    }

    void publish(const std::string& subject, const std::string& bytes) {
        std::vector<std::shared_ptr<LocalListener>> found;
        {
            const std::lock_guard lock(mutex_);
            for (const auto& listener : listeners_) {
                if (listener->subject == subject) {
                    found.push_back(listener);
                }
            }
        }
        for (const auto& listener : found) {
            const std::lock_guard running(listener->running);
            if (!listener->ended) {
                listener->handler(bytes);
            }
        }
    }

    void add(const std::shared_ptr<LocalListener>& listener) {
        const std::lock_guard lock(mutex_);
        listeners_.insert(listener);
    }

    void remove(const std::shared_ptr<LocalListener>& listener) {
        {
            const std::lock_guard lock(mutex_);
            listeners_.erase(listener);
        }
        const std::lock_guard running(listener->running);
        listener->ended = true;
    }

  private:
    std::mutex mutex_;
    std::map<std::string, BoardEntry> entries_;
    std::uint64_t revision_ = 0;
    std::set<std::shared_ptr<LocalListener>> listeners_;
};

namespace {

class LocalSubscription final : public BoardSubscription {
  public:
    LocalSubscription(std::shared_ptr<LocalHub> hub, std::shared_ptr<LocalListener> listener)
        : hub_(std::move(hub)),
          listener_(std::move(listener)) {
        hub_->add(listener_);
    }

    ~LocalSubscription() override { hub_->remove(listener_); }

  private:
    std::shared_ptr<LocalHub> hub_;
    std::shared_ptr<LocalListener> listener_;
};

class LocalBoard final : public Board {
  public:
    explicit LocalBoard(std::shared_ptr<LocalHub> hub) : hub_(std::move(hub)) {}

    BoardResult<std::optional<BoardEntry>> get(const std::string& key) override {
        return hub_->get(key);
    }

    BoardResult<std::uint64_t> put_if(const std::string& key,
                                      std::uint64_t expected,
                                      const std::string& value) override {
        return hub_->put_if(key, expected, value);
    }

    BoardResult<std::vector<std::pair<std::string, BoardEntry>>> list(
        const std::string& prefix) override {
        return hub_->list(prefix);
    }

    void publish(const std::string& subject, const std::string& bytes) override {
        hub_->publish(subject, bytes);
    }

    std::unique_ptr<BoardSubscription> subscribe(
        const std::string& subject,
        std::function<void(const std::string&)> handler) override {
        auto listener = std::make_shared<LocalListener>();
        listener->subject = subject;
        listener->handler = std::move(handler);
        return std::make_unique<LocalSubscription>(hub_, std::move(listener));
    }

    [[nodiscard]] bool connected() const override { return true; }

  private:
    std::shared_ptr<LocalHub> hub_;
};

}  // namespace

std::shared_ptr<LocalHub> make_local_hub() {
    return std::make_shared<LocalHub>();
}

std::unique_ptr<Board> make_local_board(std::shared_ptr<LocalHub> hub) {
    return std::make_unique<LocalBoard>(std::move(hub));
}

}  // namespace zoned::cluster
