#include "server/cluster/world_lease.h"

#include <chrono>
#include <cmath>
#include <utility>

namespace zoned::cluster {

namespace {

std::int64_t unix_ms() {
    using namespace std::chrono;
    return duration_cast<milliseconds>(system_clock::now().time_since_epoch()).count();
}

}  // namespace

WorldLease::WorldLease(Board& board, LeaseSettings settings, std::function<double()> clock)
    : board_(board),
      settings_(std::move(settings)),
      clock_(std::move(clock)) {
    entry_.set_world(settings_.world);
    entry_.set_instance(settings_.instance);
    entry_.set_life(settings_.life.empty() ? settings_.fresh_life : settings_.life);
    entry_.set_lease_ms(static_cast<std::uint32_t>(std::lround(1e3 * settings_.lease_s)));
}

std::string WorldLease::next_entry(bool fresh) {
    const std::lock_guard lock(mutex_);
    entry_.set_epoch(fresh ? 0 : epoch_);
    entry_.set_beat(entry_.beat() + 1);
    entry_.set_written_unix_ms(unix_ms());
    if (fresh) {
        entry_.set_claimed_unix_s(unix_ms() / 1000);
    }
    return entry_.SerializeAsString();
}

void WorldLease::held_since(double begun_s, std::uint64_t revision) {
    const std::lock_guard lock(mutex_);
    revision_ = revision;
    ends_s_ = begun_s + settings_.lease_s;
    state_ = LeaseState::kHeld;
    owner_ = entry_;
    trouble_.clear();
}

void WorldLease::note_trouble(const std::string& text) {
    const std::lock_guard lock(mutex_);
    trouble_ = text;
    if (state_ == LeaseState::kHeld && clock_() >= ends_s_) {
        state_ = LeaseState::kLapsed;
    }
}

LeaseState WorldLease::take(std::uint64_t revision) {
    const double begun_s = clock_();
    const auto written = board_.put_if(key(), revision, next_entry(true));
    if (!written.ok()) {
        // Changed: the next look tells by whom. Unknown: it will find this server's own entry.
        note_trouble(written.error().fault == BoardFault::kChanged ? "" : written.error().text);
        return LeaseState::kWaiting;
    }
    held_since(begun_s, *written);
    const std::lock_guard lock(mutex_);
    epoch_ = *written;
    return state_;
}

LeaseState WorldLease::claim() {
    const auto found = board_.get(key());
    if (!found.ok()) {
        note_trouble(found.error().text);
        return LeaseState::kWaiting;
    }
    if (!*found) {
        return take(0);
    }
    proto::cluster::WorldEntry there;
    // An entry that cannot be read is nobody's.
    const bool readable = there.ParseFromString((*found)->value);
    const double now_s = clock_();
    {
        const std::lock_guard lock(mutex_);
        trouble_.clear();
        if (seen_s_ < 0.0 || revision_ != (*found)->revision) {
            revision_ = (*found)->revision;
            seen_s_ = now_s;
        }
        owner_ = there;
    }
    // The process before this one in the same state folder is dead, which the lock of the folder
    // proves.
    const bool free = !readable || there.instance().empty() ||
                      there.instance() == settings_.instance ||
                      now_s - seen_s_ > 1e-3 * there.lease_ms() * (1.0 + kMargin);
    if (!free) {
        return LeaseState::kWaiting;
    }
    if (there.life() != settings_.life) {
        const std::lock_guard lock(mutex_);
        entry_.set_life(settings_.fresh_life);
    }
    return take((*found)->revision);
}

LeaseState WorldLease::renew() {
    if (state() == LeaseState::kLost || state() == LeaseState::kReleased) {
        return state();
    }
    const double begun_s = clock_();
    const auto written = board_.put_if(key(), revision_, next_entry(false));
    if (written.ok()) {
        held_since(begun_s, *written);
    } else if (written.error().fault == BoardFault::kChanged) {
        return look_again();
    } else {
        note_trouble(written.error().text);
    }
    return state();
}

/// Another revision: a write of this server whose answer was lost, or another server's claim.
LeaseState WorldLease::look_again() {
    const auto found = board_.get(key());
    if (!found.ok() || !*found || (*found)->revision <= revision_) {
        note_trouble(found.ok() ? "the board answers with what was before" : found.error().text);
        return state();
    }
    proto::cluster::WorldEntry there;
    static_cast<void>(there.ParseFromString((*found)->value));
    if (there.instance() == settings_.instance) {
        // Written no earlier than the attempt before this one: the next renewal prolongs it.
        const std::lock_guard lock(mutex_);
        revision_ = (*found)->revision;
        return state_;
    }
    const std::lock_guard lock(mutex_);
    owner_ = there;
    state_ = LeaseState::kLost;
    return state_;
}

void WorldLease::describe(const std::function<void(proto::cluster::WorldEntry&)>& change) {
    const std::lock_guard lock(mutex_);
    change(entry_);
}

void WorldLease::release() {
    if (state() != LeaseState::kHeld && state() != LeaseState::kLapsed) {
        return;
    }
    {
        const std::lock_guard lock(mutex_);
        entry_.clear_instance();
        entry_.clear_tcp_port();
        state_ = LeaseState::kReleased;
    }
    // Where this fails the world is free when the lease ends.
    static_cast<void>(board_.put_if(key(), revision_, next_entry(false)).ok());
}

LeaseState WorldLease::state() const {
    const std::lock_guard lock(mutex_);
    return state_ == LeaseState::kHeld && clock_() >= ends_s_ ? LeaseState::kLapsed : state_;
}

bool WorldLease::valid() const {
    return state() == LeaseState::kHeld;
}

double WorldLease::left_s() const {
    const std::lock_guard lock(mutex_);
    return ends_s_ - clock_();
}

std::uint64_t WorldLease::epoch() const {
    const std::lock_guard lock(mutex_);
    return epoch_;
}

std::string WorldLease::life() const {
    const std::lock_guard lock(mutex_);
    return entry_.life();
}

proto::cluster::WorldEntry WorldLease::owner() const {
    const std::lock_guard lock(mutex_);
    return owner_;
}

std::string WorldLease::trouble() const {
    const std::lock_guard lock(mutex_);
    return trouble_;
}

}  // namespace zoned::cluster
