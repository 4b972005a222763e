#include "server/app/recovery/server_recovery.h"

#include "server/app/log/log.h"
#include "server/app/runtime/tick_loop.h"

#include <utility>

namespace zoned::app {

ServerRecovery::ServerRecovery(const config::Settings& settings,
                               World& world,
                               const std::string& life)
    : settings_(settings),
      world_(world) {
    if (!settings.server.recovery.on) {
        return;
    }
    recovery_ = std::make_unique<Recovery>(settings);
    found_ = recovery_->begin(world, life);
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

std::set<std::string> ServerRecovery::accounts() const {
    std::set<std::string> out;
    if (on()) {
        for (const session::KeptSession& kept : recovery_->ledger().sessions()) {
            if (kept.begun.ticketed) {
                out.insert(kept.begun.account);
            }
        }
    }
    return out;
}

void ServerRecovery::restore_sessions(session::SessionHost& host,
                                      const std::set<std::string>& elsewhere,
                                      const Post& post) {
    if (!on()) {
        return;
    }
    host.number_sessions_after(recovery_->ledger().newest_client());
    for (session::KeptSession& kept : recovery_->ledger().sessions()) {
        if (kept.begun.ticketed && elsewhere.count(kept.begun.account) != 0) {
            post(mailbox::Leave{kept.begun.client, mailbox::LeaveReason::kKicked});
            ++elsewhere_;
            continue;
        }
        // Its client has seen states of which this process knows nothing.
        post(mailbox::ViewReset{kept.begun.client});
        host.restore(std::move(kept), steady_seconds());
    }
    for (const ClientId client : recovery_->ledger().kicked()) {
        post(mailbox::Leave{client, mailbox::LeaveReason::kKicked});
    }
}

std::vector<mailbox::StoreRequest> ServerRecovery::requests_again(
    const std::set<std::string>& elsewhere,
    const Post& post) {
    if (!on()) {
        return {};
    }
    std::vector<mailbox::StoreRequest> out = recovery_->ledger().ask_again(world_.now());
    const auto dropped = std::erase_if(out, [&](const mailbox::StoreRequest& request) {
        return request.act != mailbox::StoreAct::kEvent &&
               elsewhere.count(request.key.account) != 0;
    });
    if (dropped > 0 && out.empty()) {
        post(mailbox::StoreKept{world_.now()});
    }
    return out;
}

RecoveryFigures ServerRecovery::figures() const {
    return {found_.recoveries,
            found_.seconds,
            static_cast<std::uint64_t>(found_.tick - found_.snapshot),
            found_.tick,
            found_.sessions - elsewhere_,
            elsewhere_};
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
