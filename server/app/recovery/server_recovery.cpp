#include "server/app/recovery/server_recovery.h"

#include "server/app/log/log.h"
#include "server/app/runtime/tick_loop.h"

#include <utility>

namespace zoned::app {

ServerRecovery::ServerRecovery(const config::Settings& settings, World& world)
    : settings_(settings),
      world_(world) {
    if (!settings.server.recovery.on) {
        return;
    }
    recovery_ = std::make_unique<Recovery>(settings);
    found_ = recovery_->begin(world);
    if (!found_.text.empty()) {
        log_of(LogArea::kServer).warn("{}", found_.text);
    }
    if (!found_.trouble.empty()) {
        log_of(LogArea::kServer).error("not all is as it was: {}", found_.trouble);
    }
}

void ServerRecovery::keep_inputs(recording::RecorderSettings& recorder,
                                 std::function<void(Tick)> kept) {
    if (recorder.ring_s > 0.0) {
        ring_.emplace(settings_, recorder.ring_folder, recorder.header);
    }
    if (!on()) {
        return;
    }
    recorder.journal_folder = recovery_->folder();
    recorder.journal_for_power =
        settings_.server.recovery.durability == config::StoreDurability::kPower;
    recorder.kept = std::move(kept);
}

void ServerRecovery::restore_sessions(session::SessionHost& host, const Post& post) {
    if (!on()) {
        return;
    }
    host.number_sessions_after(recovery_->ledger().newest_client());
    for (session::KeptSession& kept : recovery_->ledger().sessions()) {
        // Its client has seen states of which this process knows nothing.
        post(mailbox::ViewReset{kept.begun.client});
        host.restore(std::move(kept), steady_seconds());
    }
    for (const ClientId client : recovery_->ledger().kicked()) {
        post(mailbox::Leave{client, mailbox::LeaveReason::kKicked});
    }
}

std::vector<mailbox::StoreRequest> ServerRecovery::requests_again() {
    return on() ? recovery_->ledger().ask_again(world_.now())
                : std::vector<mailbox::StoreRequest>();
}

void ServerRecovery::asked(Tick tick, const StoreTicket& ticket, const Post& post) {
    if (on() && !asked_.submitted(tick, ticket)) {
        post(mailbox::StoreKept{tick});
    }
}

void ServerRecovery::stored(std::uint64_t number, const Post& post) {
    if (on()) {
        asked_.stored(number, [&post](Tick tick) { post(mailbox::StoreKept{tick}); });
    }
}

void ServerRecovery::after_tick(std::span<const mailbox::InboxItem> in,
                                std::vector<mailbox::OutboxItem>& out,
                                recording::Recorder& recorder) {
    if (on()) {
        recovery_->after_tick(world_, in, out, recorder);
    }
    if (ring_) {
        ring_->after_tick(world_, recorder);
    }
}

void ServerRecovery::stop_ring() {
    if (!ring_) {
        return;
    }
    ring_->stop();
    if (ring_->pauses_ms().count() > 0) {
        log_of(LogArea::kServer)
            .info(
                "{} states beside the last inputs; ticks waited {:.2f} ms for one at p50, {:.2f} "
                "ms at most",
                ring_->pauses_ms().count(),
                ring_->pauses_ms().percentile(0.5),
                ring_->pauses_ms().max());
    }
}

bool ServerRecovery::end() {
    if (!on()) {
        return true;
    }
    const SnapshotFigures& made = recovery_->figures();
    log_of(LogArea::kServer)
        .info("{} snapshots, {} failed; ticks waited {:.2f} ms for one at p50, {:.2f} ms at most",
              made.taken,
              made.failed,
              recovery_->pauses_ms().percentile(0.5),
              recovery_->pauses_ms().max());
    const std::string wrong = recovery_->end(world_);
    if (!wrong.empty()) {
        log_of(LogArea::kServer).error("{}", wrong);
    }
    return wrong.empty();
}

}  // namespace zoned::app
