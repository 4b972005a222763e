// StoreService: the thread that writes the store. A tick's requests are one transaction, and the
// tick loop never waits for a disk.
#pragma once

#include "server/mailbox/store_messages.h"
#include "server/store/store.h"
#include "shared/core/histogram.h"

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace zoned::store {

struct StoreServiceSettings {
    std::size_t max_waiting_bytes = 64U << 20U;  ///< more requests are refused
    double retry_s = 0.05;                       ///< after a failed commit; doubles up to:
    double most_retry_s = 1.0;
    double stop_patience_s = 5.0;  ///< at the end the store gets this long to take what waits
    double checkpoint_s = 1.0;
    std::string world;  ///< digest of the config, see StandingPlace
};

struct StoreFigures {
    std::uint64_t commits = 0;
    std::uint64_t changes = 0;
    std::uint64_t reads = 0;
    std::uint64_t failures = 0;  ///< commits and reads that failed, and were tried again
    std::uint64_t checkpoint_failures = 0;
    std::uint64_t refused = 0;  ///< requests for which there was no room
    std::uint64_t lost = 0;     ///< changes that the store did not take before the server ended
    std::uint64_t waiting_bytes = 0;
    core::Histogram commit_ms;
    std::string failing;  ///< why, as long as the last commit failed; empty: it did not
};

/// The answer to a request, without a value.
[[nodiscard]] mailbox::StoreAnswer answer_to(const mailbox::StoreRequest& request,
                                             mailbox::StoreStatus status);

/// Called on the writer's thread; must not call back.
struct StoreServiceOutput {
    /// To the inbox of the world.
    std::function<void(mailbox::StoreAnswer)> answer;
    /// All that was submitted up to this number is durable, or was refused.
    std::function<void(std::uint64_t number)> durable;
    /// The store fails (text), or works again (empty).
    std::function<void(const std::string& text)> trouble;
};

/// The result of a login's transaction.
struct LoginResult {
    bool stored = false;
    std::optional<StandingPlace> place;
};

class StoreService {
  public:
    /// `checkpoint` may be empty; it is called on a thread of its own.
    StoreService(std::unique_ptr<Store> store,
                 StoreServiceSettings settings,
                 StoreServiceOutput output,
                 std::function<StoreResult<bool>()> checkpoint = {});
    /// Writes what waits, as long as the store takes it.
    ~StoreService();

    /// Writes what waits, within the patience of the settings. Later submissions are refused.
    void stop();

    // From any thread; none waits.

    /// A tick's requests, as one transaction. Returns the number under which they become durable;
    /// 0: there was no room, and all of them are answered so.
    std::uint64_t submit(Tick tick, std::vector<mailbox::StoreRequest>&& requests);
    /// `done` is called on the writer's thread: false where there was no room.
    void submit(std::vector<StoreChange> changes, std::function<void(bool)> done);
    /// Notes the login, and the ticket where there is one.
    void log_in(NoteLogin login,
                std::optional<UseTicket> ticket,
                std::function<void(LoginResult)> done);

    /// The records of an account and of its characters, behind all that was submitted before;
    /// none where the store cannot say. `done` is called on the writer's thread.
    void read_records(std::string account,
                      std::function<void(std::optional<std::vector<PutRecord>>)> done);

    [[nodiscard]] StoreFigures figures() const;

  private:
    struct Job {
        std::uint64_t number = 0;
        std::vector<StoreChange> changes;
        std::vector<mailbox::StoreRequest> requests;  ///< without values that went into `changes`
        std::function<void(bool)> done;
        std::function<void(LoginResult)> logged_in;
        NoteLogin login;
        std::string records_of;  ///< account
        std::function<void(std::optional<std::vector<PutRecord>>)> records_read;
        std::size_t bytes = 0;
    };

    /// The number of the job, which is taken; 0: there is no room, and it stays as it is.
    std::uint64_t push(Job& job);
    void run();
    void run_checkpoints();
    /// One transaction of all these jobs; true when they are done.
    bool work(std::vector<Job>& jobs);
    void answer(const Job& job);
    void refuse(const Job& job);
    void failed(const StoreError& why);
    void worked();

    std::unique_ptr<Store> store_;
    StoreServiceSettings settings_;
    StoreServiceOutput output_;
    std::function<StoreResult<bool>()> checkpoint_;

    mutable std::mutex mutex_;
    std::condition_variable wake_;             // the writer's
    std::condition_variable checkpoint_wake_;  // of the thread of checkpoints
    std::deque<Job> waiting_;
    std::uint64_t next_ = 0;
    bool stopping_ = false;
    StoreFigures figures_;

    std::vector<StoreChange> batch_;  // scratch of the writer
    std::thread writer_;
    std::thread checkpoints_;
};

}  // namespace zoned::store
