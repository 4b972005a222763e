// ServerRecovery: recovery and the states beside the last inputs, wired to the world, the sessions,
// the recorder and the store of a server.
#pragma once

#include "server/app/recovery/recovery.h"
#include "server/app/recovery/recovery_figures.h"
#include "server/app/recovery/ring_states.h"
#include "server/app/storage/asked_ticks.h"
#include "server/app/storage/held_output.h"

#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

namespace zoned::app {

/// Without recovery it keeps states beside the last inputs, no more.
class ServerRecovery {
  public:
    using Post = std::function<void(mailbox::InboxItem)>;

    /// Brings back what a server left that died, if one did, and logs it. Throws
    /// std::runtime_error that says what to do. `life` as in Recovery::begin().
    ServerRecovery(const config::Settings& settings, World& world, const std::string& life);

    [[nodiscard]] bool on() const { return recovery_ != nullptr; }

    /// Has the recorder keep the inputs; `kept` as RecorderSettings::kept.
    void keep_inputs(recording::RecorderSettings& recorder, std::function<void(Tick)> kept);

    /// Accounts with a ticket whose clients were in the world.
    [[nodiscard]] std::set<std::string> accounts() const;

    /// As Recovery::refused().
    void refused() const { recovery_->refused(); }

    /// Before the first tick: clients of the server before this one may come back, and the world
    /// hears of those who cannot. Accounts that are `elsewhere` leave it.
    void restore_sessions(session::SessionHost& host,
                          const std::set<std::string>& elsewhere,
                          const Post& post);

    /// Requests of which the store may not have heard; without those for accounts that are
    /// elsewhere, whose records are the other world's.
    [[nodiscard]] std::vector<mailbox::StoreRequest> requests_again(
        const std::set<std::string>& elsewhere,
        const Post& post);

    [[nodiscard]] RecoveryFigures figures() const;

    /// Requests of a tick were given to the store.
    void asked(Tick tick, const StoreTicket& ticket, const Post& post);
    /// The store has come to this number; from any thread.
    void stored(std::uint64_t number, const Post& post);

    /// Whether anything is to be done after ticks.
    [[nodiscard]] bool watches_ticks() const { return on() || ring_.has_value(); }

    /// As Recovery::after_tick().
    void after_tick(std::span<const mailbox::InboxItem> in,
                    std::vector<mailbox::OutboxItem>& out,
                    recording::Recorder& recorder);

    /// Before the recorder is closed.
    void stop_ring();

    /// After a run that ends in good order; false, and a line in the log: not all was done.
    bool end();

  private:
    const config::Settings& settings_;
    World& world_;
    std::unique_ptr<Recovery> recovery_;  // null: a crash ends the world
    std::optional<RingStates> ring_;
    RecoveredRun found_;
    std::uint64_t elsewhere_ = 0;
    AskedTicks asked_;
};

}  // namespace zoned::app
