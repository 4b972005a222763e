#include "server/app/replay/replay_loop.h"

#include "server/app/world/replayed_tick.h"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <utility>

namespace zoned::app {

namespace {

constexpr auto kReplayPause = std::chrono::milliseconds(10);
constexpr double kReplayFiguresEvery_s = 0.25;
/// Viewers see a world that runs fast, while it is simulated to a tick.
constexpr double kShowEvery_s = 0.03;
/// So far behind its pace a machine that is too slow may fall, s.
constexpr double kMostBehind_s = 0.25;
constexpr double kKeepEvery_s = 10.0;
/// Snapshots that take more than this become half as many, twice as far apart.
constexpr std::size_t kMostKeptBytes = std::size_t{512} << 20U;

}  // namespace

ReplayLoop::ReplayLoop(const config::Settings& settings, std::string file, unsigned threads)
    : settings_(settings),
      file_(std::move(file)),
      threads_(threads),
      keep_every_(std::max<Tick>(1, static_cast<Tick>(kKeepEvery_s * settings.tick_rate_hz))) {
}

ReplayLoop::~ReplayLoop() {
    stop();
}

core::Result<bool> ReplayLoop::open() {
    recording::RecordingReader reader;
    auto more = reader.open(file_);
    before_ = more.ok() && reader.state() ? reader.state()->tick : 0;
    for (more = more.ok() ? reader.next(record_) : more; more.ok() && *more;
         more = reader.next(record_)) {
        if (last_ == 0 && record_.tick != before_ + 1) {
            return core::Result<bool>::failure(
                file_ + " begins with tick " + std::to_string(record_.tick) +
                ", without the state of the world before it: it cannot be simulated");
        }
        last_ = record_.tick;
    }
    if (last_ == 0) {
        return core::Result<bool>::failure(more.ok() ? file_ + " holds no tick" : more.error());
    }
    if (!more.ok()) {
        fault_ = more.error();
    }
    const std::string bad_state = begin_anew();
    return bad_state.empty() ? core::Result<bool>(true)
                             : core::Result<bool>::failure(file_ + ": " + bad_state);
}

void ReplayLoop::start() {
    thread_ = std::thread([this] { loop(); });
}

void ReplayLoop::stop() {
    stop_.store(true);
    if (thread_.joinable()) {
        thread_.join();
    }
}

ReplayState ReplayLoop::state() const {
    const std::lock_guard lock(mutex_);
    return {last_, tick_.load(), target_.load(), fault_, differs_, simulated_.load()};
}

void ReplayLoop::loop() {
    while (!stop_.load(std::memory_order_relaxed)) {
        const double scale = time_scale_.load();
        const Tick target = target_.load();
        if (target != 0) {
            go_to(target);
        } else if (scale > 0.0 && world_->now() < last_) {
            play(scale);
        } else {
            stand_still();
        }
    }
}

std::string ReplayLoop::begin_anew() {
    world_ = nullptr;  // the old one first: there may be no room for two
    world_ = std::make_unique<World>(settings_, threads_, &thread_cpu_ns);
    reader_ = recording::RecordingReader();
    // It was read before; a file that has gone since ends the replay at its first tick.
    [[maybe_unused]] const auto opened = reader_.open(file_);
    const std::string bad_state = begin_with_state(reader_, *world_);
    tick_.store(world_->now());
    return bad_state;
}

const ReplayLoop::KeptState* ReplayLoop::kept_before(Tick target) const {
    const auto after =
        std::upper_bound(kept_.begin(), kept_.end(), target, [](Tick t, const KeptState& kept) {
            return t < kept.tick;
        });
    return after == kept_.begin() ? nullptr : &*std::prev(after);
}

void ReplayLoop::begin_before(Tick target) {
    begin_anew();
    const KeptState* kept = kept_before(target);
    if (kept == nullptr) {
        return;
    }
    const auto found = reader_.seek(kept->tick + 1);
    if (!world_->load(kept->bytes).empty() || !found.ok()) {
        begin_anew();
        return;
    }
    tick_.store(world_->now());
}

void ReplayLoop::keep_state() {
    const Tick now = world_->now();
    if (now % keep_every_ != 0 || (!kept_.empty() && kept_.back().tick >= now)) {
        return;
    }
    KeptState kept{now, {}};
    if (!world_->save(kept.bytes).empty()) {
        return;  // it may have a saved form later
    }
    kept.bytes.shrink_to_fit();
    kept_bytes_ += kept.bytes.size();
    kept_.push_back(std::move(kept));
    while (kept_bytes_ > kMostKeptBytes) {
        keep_every_ *= 2;
        std::erase_if(kept_, [this](const KeptState& one) {
            const bool goes = one.tick % keep_every_ != 0;
            kept_bytes_ -= goes ? one.bytes.size() : 0;
            return goes;
        });
    }
}

void ReplayLoop::go_to(Tick target) {
    const KeptState* kept = kept_before(target);
    if (target < world_->now() || (kept != nullptr && kept->tick > world_->now())) {
        begin_before(target);
    }
    double show_s = steady_seconds() + kShowEvery_s;
    while (world_->now() < target && target_.load() == target && !stop_.load() &&
           step(world_->now() + 1 == target)) {
        if (const double now = steady_seconds(); now >= show_s) {
            show_s = now + kShowEvery_s;
            publish();
            visits_.answer(*world_);
        }
    }
    Tick reached = target;
    target_.compare_exchange_strong(reached, 0);
    due_s_ = steady_seconds();
    visits_.answer(*world_);
}

void ReplayLoop::stand_still() {
    for (unsigned steps = steps_.exchange(0); steps > 0 && step(true); --steps) {
    }
    publish();
    visits_.answer(*world_);
    due_s_ = steady_seconds();
    std::this_thread::sleep_for(kReplayPause);
}

void ReplayLoop::play(double scale) {
    const double now = steady_seconds();
    due_s_ = std::max(due_s_ + 1.0 / (settings_.tick_rate_hz * scale), now - kMostBehind_s);
    // A pace of hardly anything must not keep a wish waiting.
    const double sleep_s = std::min(due_s_ - now, 0.5);
    if (sleep_s > 0.0) {
        std::this_thread::sleep_for(std::chrono::duration<double>(sleep_s));
    }
    step(true);
    publish();
    visits_.answer(*world_);
}

bool ReplayLoop::step(bool compare) {
    if (world_->now() >= last_) {
        return false;
    }
    const double begin = steady_seconds();
    const auto more = reader_.next(record_);
    const bool good = more.ok() && *more;
    const std::string wrong =
        good ? replayed_tick(settings_, record_, compare, *world_) : std::string();
    if (!good || !wrong.empty()) {
        const std::lock_guard lock(mutex_);
        differs_ = differs_ || good;
        if (fault_.empty()) {
            fault_ = good ? wrong : more.ok() ? file_ + " ends early" : more.error();
        }
    }
    if (!good) {
        time_scale_.store(0.0);
        return false;
    }
    tick_.store(world_->now());
    simulated_.fetch_add(1);
    keep_state();
    figures_.wall_ms.add(1e3 * (steady_seconds() - begin));
    count();
    return true;
}

void ReplayLoop::count() {
    figures_.ticks = world_->now();
    figures_.entities = 0;
    figures_.awake_bodies = 0;
    figures_.zones.clear();
    for (const auto& zone : world_->zones()) {
        const zone::StepReport& report = zone->report();
        ZoneSample& sample = figures_.zones.emplace_back();
        sample.entities = report.census.entities;
        sample.awake_bodies = report.census.awake_bodies;
        sample.viewers = report.census.viewers;
        for (std::size_t p = 0; p < zone::kPasses; ++p) {
            figures_.passes[p].ns += report.passes[p].ns;
            figures_.passes[p].ran += report.passes[p].ran ? 1 : 0;
            sample.step_ns += report.passes[p].ns;
        }
        figures_.entities += sample.entities;
        figures_.awake_bodies += sample.awake_bodies;
    }
}

void ReplayLoop::publish() {
    const double now = steady_seconds();
    if (now < publish_due_s_ || figures_.ticks == 0) {
        return;
    }
    publish_due_s_ = now + kReplayFiguresEvery_s;
    auto copy = std::make_shared<LoopStats>(figures_);
    copy->published_s = now;
    published_.publish(std::move(copy));
}

}  // namespace zoned::app
