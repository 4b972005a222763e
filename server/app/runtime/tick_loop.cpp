#include "server/app/runtime/tick_loop.h"

#include "server/app/log/log.h"
#include "server/app/runtime/state_flapping_report.h"
#include "shared/core/signal_stack.h"

#include <sys/prctl.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <utility>

namespace zoned::app {

namespace {

/// By so much the kernel may delay a wake-up in order to join it with others (prctl(2),
/// PR_SET_TIMERSLACK; 50 us by default). The loop asks for precision in place of waiting awake.
constexpr unsigned long kTimerSlack_ns = 1000;
/// Between two looks while the loop stands still.
constexpr auto kStandingPause = std::chrono::milliseconds(10);

/// Sums of traffic are for people: so many ticks old at most.
constexpr Tick kTrafficEvery = 30;
constexpr double kBandsEvery_s = 10.0;
constexpr double kTurnsOver_s = 10.0;

std::string overrun_cause(const LoopStats& stats, double wall_s, double cpu_s, double period_s) {
    if (cpu_s > period_s) {
        return stats.ticks == 0 ? "first tick" : "step took longer than a period of CPU time";
    }
    return wall_s - cpu_s > 0.5 * wall_s ? "threads were not scheduled"
                                         : "threads were partly not scheduled";
}

}  // namespace

double steady_seconds() {
    using Clock = std::chrono::steady_clock;
    return std::chrono::duration<double>(Clock::now().time_since_epoch()).count();
}

std::uint64_t thread_cpu_ns() {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<std::uint64_t>(t.tv_sec) * 1000000000ull +
           static_cast<std::uint64_t>(t.tv_nsec);
}

TickLoop::TickLoop(World& world,
                   const LoopSettings& settings,
                   std::function<void(TickResult)> deliver,
                   recording::Recorder* recorder)
    : world_(world),
      settings_(settings),
      deliver_(std::move(deliver)),
      recorder_(recorder),
      schedule_(settings.rate_hz, settings.max_catch_up, steady_seconds()),
      inbox_(settings.mailbox_capacity) {
    if (settings.cluster != nullptr) {
        portals_ =
            std::make_unique<PortalWatch>(settings.cluster->server.portals, settings.rate_hz);
    }
}

TickLoop::~TickLoop() {
    stop();
}

void TickLoop::start() {
    schedule_ =
        TickSchedule(settings_.rate_hz, settings_.max_catch_up, steady_seconds(), world_.now());
    thread_ = std::thread([this] { loop(); });
}

void TickLoop::stop() {
    stop_.store(true);
    if (thread_.joinable()) {
        thread_.join();
        const std::lock_guard lock(stats_mutex_);
        count_traffic();
    }
}

LoopStats TickLoop::stats() const {
    const std::lock_guard lock(stats_mutex_);
    LoopStats copy = stats_;
    copy.inbox_dropped = inbox_.dropped();
    if (recorder_ != nullptr) {
        copy.recording = recorder_->figures();
    }
    return copy;
}

void TickLoop::loop() {
    core::add_signal_stack();
    ::prctl(PR_SET_TIMERSLACK, kTimerSlack_ns, 0UL, 0UL, 0UL);
    while (!stop_.load(std::memory_order_relaxed)) {
        const double scale = time_scale_.load(std::memory_order_relaxed);
        if (scale != clock_.scale()) {
            clock_.set_scale(scale, steady_seconds());
        }
        if (!clock_.runs()) {
            stand_still();
            continue;
        }
        wait_until(schedule_.next_due());
        while (schedule_.due(clock_.time(steady_seconds())) &&
               !stop_.load(std::memory_order_relaxed)) {
            run_tick(schedule_.next_due());
            schedule_.ran();
        }
    }
}

void TickLoop::wait_until(double time_s) {
    double sleep_s = clock_.until(time_s, steady_seconds());
    while (sleep_s > 0.0) {
        std::this_thread::sleep_for(std::chrono::duration<double>(sleep_s));
        sleep_s = clock_.until(time_s, steady_seconds());
    }
}

/// Runs the ticks that were asked for, and answers visits.
void TickLoop::stand_still() {
    unsigned steps = steps_.exchange(0);
    for (; steps > 0 && !stop_.load(std::memory_order_relaxed); --steps) {
        clock_.skip(schedule_.next_due() - clock_.time(steady_seconds()));
        run_tick(schedule_.next_due());
        schedule_.ran();
    }
    publish();
    visits_.answer(world_);
    turns_.fetch_add(1, std::memory_order_relaxed);
    std::this_thread::sleep_for(kStandingPause);
}

void TickLoop::run_tick(double due_s) {
    const double begin = steady_seconds();
    const std::uint64_t cpu_begin = thread_cpu_ns() + world_.pool().cpu_ns();
    TickResult result;
    result.load = turn_load_;
    const std::size_t known_stopped = world_.stopped().size();
    step_world(result.items);
    if (settings_.to_store && !world_.store_requests().empty()) {
        result.store = settings_.to_store(world_.now(), std::move(world_.store_requests()));
    }
    if (portals_) {
        watch_travel(result);
    }
    result.tick = world_.now();
    result.server_time_s = static_cast<double>(world_.now()) * schedule_.dt_s();
    result.clock_origin_s = begin - schedule_.server_time(clock_.time(begin));
    const double next_s = schedule_.next_due() + schedule_.dt_s();
    result.next_due_s = clock_.runs() ? begin + clock_.until(next_s, begin) : begin;
    deliver_(std::move(result));
    const std::uint64_t cpu_end = thread_cpu_ns() + world_.pool().cpu_ns();
    const double end = steady_seconds();
    count_tick(clock_.time(begin) - due_s, end - begin, cpu_end - cpu_begin);
    log_.limits(world_, end);
    log_.overload(load_);
    if (world_.stopped().size() > known_stopped) {
        log_.stopped_zones(world_);
        if (settings_.on_stopped_zone) {
            settings_.on_stopped_zone();
        }
    }
    publish();
    visits_.answer(world_);
    count_turn(steady_seconds() - begin, thread_cpu_ns() + world_.pool().cpu_ns() - cpu_begin);
    turns_.fetch_add(1, std::memory_order_relaxed);
}

void TickLoop::watch_travel(TickResult& result) {
    portals_->look(world_, result.wishes, result.ahead);
    for (const auto& zone : world_.zones()) {
        const std::vector<TravelWish>& travels = zone->output().travels;
        result.wishes.insert(result.wishes.end(), travels.begin(), travels.end());
        const std::vector<ClientId>& departed = zone->output().departed;
        result.departed.insert(result.departed.end(), departed.begin(), departed.end());
    }
}

void TickLoop::publish() {
    const double now = steady_seconds();
    if (settings_.publish_every_s <= 0.0 || now < publish_due_s_) {
        return;
    }
    publish_due_s_ = now + settings_.publish_every_s;
    auto copy = std::make_shared<LoopStats>(stats());
    copy->published_s = now;
    published_.publish(std::move(copy));
}

void TickLoop::step_world(std::vector<mailbox::OutboxItem>& out) {
    if (recorder_ == nullptr) {
        inbox_.take_all(items_);
        begun_.store(world_.now() + 1, std::memory_order_relaxed);
        world_.tick(items_, out);
        world_.hash_zones(hashes_);
        return;
    }
    const std::shared_ptr<recording::Inputs> inputs = recorder_->lend();
    inbox_.take_all(*inputs);
    begun_.store(world_.now() + 1, std::memory_order_relaxed);
    recorder_->begin_tick(world_.now() + 1, inputs);
    world_.tick(*inputs, out);
    world_.hash_zones(hashes_);
    recorder_->end_tick(world_.now(), hashes_);
    if (settings_.after_tick) {
        settings_.after_tick(*inputs, out);
    }
}

void TickLoop::count_turn(double wall_s, std::uint64_t cpu_ns) {
    turn_load_ = std::min(kMostLoad, wall_s / schedule_.dt_s());
    turns_ms_.add(1e3 * wall_s);
    turns_cpu_ms_.add(1e-6 * static_cast<double>(cpu_ns));
    if (static_cast<double>(turns_ms_.count()) < kTurnsOver_s / schedule_.dt_s()) {
        return;
    }
    {
        const std::lock_guard lock(stats_mutex_);
        stats_.turn_ms = turns_ms_;
        stats_.turn_cpu_ms = turns_cpu_ms_;
    }
    turns_ms_ = {};
    turns_cpu_ms_ = {};
}

void TickLoop::count_tick(double late_s, double wall_s, std::uint64_t cpu_ns) {
    const std::lock_guard lock(stats_mutex_);
    LoopStats& s = stats_;
    s.wall_ms.add(1e3 * wall_s);
    s.cpu_ms.add(1e-6 * static_cast<double>(cpu_ns));
    s.late_ms.add(1e3 * late_s);
    s.cpu_ns += cpu_ns;
    if (wall_s > schedule_.dt_s()) {
        ++s.overruns;
        const std::string cause =
            overrun_cause(s, wall_s, static_cast<double>(cpu_ns) * 1e-9, schedule_.dt_s());
        ++s.overrun_causes[cause];
        log_.overrun(world_, {1e3 * wall_s, 1e3 * schedule_.dt_s(), cause}, steady_seconds());
    }
    ++s.ticks;
    s.dropped_ticks = schedule_.dropped();
    s.handoffs = world_.handoffs();
    s.client_handoffs = world_.client_handoffs();
    s.undeliverable = world_.undeliverable();
    s.script_errors = world_.script_errors();
    if (const zone::PartyBook* const parties = world_.parties()) {
        s.parties = parties->parties().size();
        s.party_orders_refused = parties->refused();
    }
    s.bursts_sent = world_.bursts_sent();
    s.entities = 0;
    s.awake_bodies = 0;
    s.particles = 0;
    load_ = {};
    s.late_clients = 0;
    s.widened_clients = 0;
    s.unreached = 0;
    s.zones.clear();
    s.stopped.assign(world_.stopped().begin(), world_.stopped().end());
    zone_ran_.resize(world_.zones().size());
    for (std::size_t i = 0; i < world_.zones().size(); ++i) {
        count_zone(i);
    }
    s.state_hash = world_hash(hashes_);
    if (s.ticks % kTrafficEvery == 0) {
        count_traffic();
    }
}

void TickLoop::count_traffic() {
    stats_.traffic = wire::TrafficTable{};
    world_.sum_traffic(stats_.traffic);
    stats_.state_flapping = flapping_of(world_.zones());
    tell_flapping(stats_.state_flapping, flapping_logged_);
    log_bands(bands_of(world_.zones()),
              world_.now(),
              static_cast<Tick>(kBandsEvery_s / schedule_.dt_s()),
              logged_bands_);
}

void TickLoop::count_zone(std::size_t index) {
    LoopStats& s = stats_;
    const zone::Zone& zone = *world_.zones()[index];
    const zone::StepReport& r = zone.report();
    log_difficulty(zone);
    std::uint64_t step_ns = 0;
    for (std::size_t p = 0; p < zone::kPasses; ++p) {
        PassTotals& total = s.passes[p];
        const bool ran = r.passes[p].ran;
        total.zones += ran && !zone_ran_[index][p] ? 1 : 0;
        zone_ran_[index][p] = zone_ran_[index][p] || ran;
        total.ran += ran ? 1 : 0;
        total.skipped += ran ? 0 : 1;
        total.ns += r.passes[p].ns;
        step_ns += r.passes[p].ns;
        total.count += r.passes[p].count;
        if (!ran) {
            total.skip_reason = r.plan.reason[p];
        }
    }
    s.rules.take(zone.state().out.figures, index);
    for (const std::string& line : zone.state().out.lines) {
        log_of(LogArea::kWorld).info("rules of zone {}: {}", index + 1, line);
    }
    s.entities += r.census.entities;
    s.awake_bodies += r.census.awake_bodies;
    s.limit_exceeded += r.replication.limit_exceeded;
    s.fields_clamped += r.fields_clamped;
    s.fields_refused += r.fields_refused;
    s.over_budget += r.replication.over_budget;
    s.inputs += r.replication.inputs;
    s.inputs_missing += r.replication.inputs_missing;
    s.records_sent += r.replication.records_sent;
    s.records_resent += r.replication.records_resent;
    s.records_repeated += r.replication.records_repeated;
    s.packets_given_up += r.replication.packets_given_up;
    s.packets_found += r.replication.packets_found;
    s.widened_clients += r.replication.widened;
    s.late_clients += r.replication.late;
    load_.clients += r.census.viewers;
    load_.late += r.replication.late;
    load_.widened += r.replication.widened;
    s.unreached += r.replication.unreached;
    s.publications += r.replication.publications;
    s.out_of_world += r.out_of_world;
    s.quarantined += r.physics.quarantined + r.soft.quarantined;
    s.deformations_beyond += r.deformations_beyond;
    s.substep_limited += r.physics.substep_limited;
    s.far_bodies += r.physics.far_bodies;
    s.held_back += r.physics.held_back;
    s.slowed += r.physics.slowed;
    s.broadcast_ticks += r.interest.broadcast ? 1 : 0;
    s.particles += r.particles.particles;
    s.device_particles += r.particles.on_device;
    if (!r.particles.fault.empty() && s.device_faults++ == 0) {
        log_of(LogArea::kWorld)
            .warn("compute.device: the device is given up, the CPU goes on: {}", r.particles.fault);
    }
    s.zones.push_back({r.census.entities,
                       r.census.ghosts,
                       r.census.awake_bodies,
                       r.census.viewers,
                       step_ns,
                       hashes_[index]});
}

}  // namespace zoned::app
