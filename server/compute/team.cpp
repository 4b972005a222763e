#include "server/compute/team.h"

#include "server/compute/spin_wait.h"
#include "server/compute/worker_pool.h"
#include "shared/core/assert.h"

namespace zoned::compute {

namespace {

/// One word, so that it changes as one: 30 bits for the stage, 17 each for the blocks' range.
struct Ticket {
    static constexpr unsigned kBits = 17;
    static constexpr std::uint64_t kMask = (std::uint64_t{1} << kBits) - 1;
    static constexpr std::uint64_t kFirst = std::uint64_t{1} << kBits;
    static constexpr std::uint64_t kStage = std::uint64_t{1} << (2 * kBits);

    static std::uint64_t next_stage(std::uint64_t ticket, std::uint32_t blocks) {
        return (ticket & ~(kStage - 1)) + kStage + blocks;
    }

    static std::uint32_t first(std::uint64_t ticket) {
        return static_cast<std::uint32_t>(ticket >> kBits & kMask);
    }

    static std::uint32_t end(std::uint64_t ticket) {
        return static_cast<std::uint32_t>(ticket & kMask);
    }
};

}  // namespace

Team::~Team() {
    ZONED_ASSERT(!open_, "a team ends after its last shift");
}

void Team::join_pool(WorkerPool& pool) {
    ZONED_ASSERT(!open_, "a team changes pools between shifts");
    pool_ = &pool;
}

void Team::open() {
    if (pool_ != nullptr && pool_->threads() > 1) {
        more_to_come_.store(true, std::memory_order_relaxed);
        place_ = pool_->post(*this);
        open_ = place_ != WorkerPool::kNoPlace;
    }
}

void Team::close() {
    if (open_) {
        more_to_come_.store(false, std::memory_order_release);
        pool_->withdraw(place_);
        open_ = false;
    }
}

void Team::publish(std::uint32_t blocks, Call call, void* context) {
    call_.store(call, std::memory_order_relaxed);
    context_.store(context, std::memory_order_relaxed);
    unfinished_.store(blocks, std::memory_order_relaxed);
    ticket_.store(Ticket::next_stage(ticket_.load(std::memory_order_relaxed), blocks),
                  std::memory_order_release);
}

void Team::run_blocks(std::uint32_t blocks, Call call, void* context) {
    publish(blocks, call, context);
    while (work(TeamEnd::kFront)) {
    }
    Spin spin;
    while (!finished()) {
        spin.wait();
    }
}

bool Team::work(TeamEnd end) {
    std::uint64_t ticket = ticket_.load(std::memory_order_acquire);
    for (;;) {
        if (Ticket::first(ticket) >= Ticket::end(ticket)) {
            return false;
        }
        const bool front = end == TeamEnd::kFront;
        const std::uint32_t block = front ? Ticket::first(ticket) : Ticket::end(ticket) - 1;
        const std::uint64_t taken = front ? ticket + Ticket::kFirst : ticket - 1;
        // These belong to the stage of the ticket if the exchange succeeds: the leader writes them
        // anew only after all blocks were taken.
        const Call call = call_.load(std::memory_order_relaxed);
        void* const context = context_.load(std::memory_order_relaxed);
        if (ticket_.compare_exchange_weak(
                ticket, taken, std::memory_order_acq_rel, std::memory_order_acquire)) {
            call(context, block);
            unfinished_.fetch_sub(1, std::memory_order_acq_rel);
            return true;
        }
    }
}

bool Team::help() {
    bool worked = false;
    Spin spin;
    for (;;) {
        if (work(TeamEnd::kBack)) {
            worked = true;
            spin = Spin();
        } else if (more_to_come_.load(std::memory_order_acquire)) {
            spin.wait();
        } else {
            return worked;
        }
    }
}

}  // namespace zoned::compute
