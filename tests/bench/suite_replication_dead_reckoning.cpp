#include "client-sim/view/view.h"
#include "server/replication/replicator.h"
#include "tests/bench/comparison.h"
#include "tests/bench/motion_traces.h"
#include "tests/bench/suite_replication.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <deque>
#include <iterator>

namespace zoned::bench {

namespace {

constexpr float kOrientationBound = 0.1F;
constexpr double kHeartbeatS = 2.0;
constexpr ClientId kWatcher(1);

struct Predictor {
    const char* name;
    int forced;
};

constexpr std::array<Predictor, 6> kPredictors{{{"default", -1},
                                                {"order0", 0},
                                                {"order1", 1},
                                                {"order2", 2},
                                                {"ballistic", 3},
                                                {"turning", 4}}};

/// How a client displays what it hears.
struct Watcher {
    const char* name;
    view::ViewKind kind = view::ViewKind::kExtrapolate;
    motion::ConvergenceMethod convergence = motion::ConvergenceMethod::kProjectiveVelocity;
    view::Shows shows = view::Shows::kPredicted;
};

constexpr std::array<Watcher, 6> kWatchers{
    {{"default"},
     {"snap", view::ViewKind::kExtrapolate, motion::ConvergenceMethod::kSnap},
     {"linear", view::ViewKind::kExtrapolate, motion::ConvergenceMethod::kLinear},
     {"hermite", view::ViewKind::kExtrapolate, motion::ConvergenceMethod::kHermite},
     {"unpredicted",
      view::ViewKind::kExtrapolate,
      motion::ConvergenceMethod::kProjectiveVelocity,
      view::Shows::kPublished},
     {"interpolate", view::ViewKind::kInterpolate}}};

/// One level of detail with the threshold for its bound; the steps of quantisation follow from it
/// as those of a world do.
replication::Settings settings_for(const MotionTrace& trace, float threshold_m, int forced) {
    replication::Settings s;
    s.lods = {{threshold_m, kOrientationBound}};
    s.heartbeat_ticks =
        static_cast<std::uint32_t>(std::lround(kHeartbeatS / static_cast<double>(trace.tick_s)));
    s.budget_bytes_per_s = 100'000'000;
    s.tick_s = trace.tick_s;
    s.forced_order = forced;
    s.ground = trace.ground;
    const wire::RateSteps steps =
        wire::rate_steps(threshold_m, kOrientationBound, static_cast<float>(0.5 * kHeartbeatS));
    s.quantization.position_step_m = std::min(0.01F, 0.2F * threshold_m);
    s.quantization.velocity_step_mps = steps.velocity_mps;
    s.quantization.acceleration_step_mps2 = steps.acceleration_mps2;
    s.quantization.angular_velocity_step_rps = steps.angular_velocity_rps;
    s.quantization.gravity_mps2 = trace.gravity_mps2;
    return s;
}

/// The world as the client of such a replicator knows it.
std::shared_ptr<const view::World> world_of(const MotionTrace& trace,
                                            const replication::Settings& settings) {
    view::World world;
    world.tick_s = static_cast<double>(trace.tick_s);
    world.quantization = settings.quantization;
    view::TypeInfo type;
    type.name = trace.type.name;
    type.upright = trace.type.upright();
    world.types.push_back(type);
    world.lods.push_back({0.0F, settings.lods[0].position_m, settings.lods[0].orientation_rad});
    view::ZoneInfo zone;
    zone.id = ZoneId(1);
    world.zones.push_back(zone);
    return std::make_shared<const view::World>(std::move(world));
}

/// Root of the mean square, and the largest.
struct Figure {
    std::uint64_t count = 0;
    double squares = 0.0;
    double largest = 0.0;

    void add(double value) {
        ++count;
        squares += value * value;
        largest = std::max(largest, value);
    }

    [[nodiscard]] double rms() const {
        return std::sqrt(squares / static_cast<double>(std::max<std::uint64_t>(count, 1)));
    }
};

/// A trace through the replicator to one client that sees everything, without loss, `delay` ticks
/// after it was sent.
class ReckoningTrial : public JudgedTrial {
  public:
    ReckoningTrial(const MotionTrace& trace,
                   float threshold_m,
                   int forced,
                   const Watcher& watcher,
                   Tick delay)
        : trace_(trace),
          delay_(delay),
          settings_(settings_for(trace, threshold_m, forced)),
          types_{trace.type},
          replicator_(settings_),
          view_(world_of(trace, settings_),
                view::ViewSettings{watcher.convergence, false, watcher.kind, watcher.shows},
                nullptr),
          shown_(trace.frames.front().size()) {
        for (std::uint32_t id = 1; id <= shown_.size(); ++id) {
            entities_.add(EntityId(id), 0);
            visible_.visible.push_back({EntityId(id), 0});
        }
        visible_.client = kWatcher;
        replication::ClientTransfer client;
        client.client = kWatcher;
        replicator_.add_client(client);
    }

    void frame() override {
        const std::vector<TracedState>& now = trace_.frames[static_cast<std::size_t>(tick_)];
        ++tick_;
        for (world::Row row = 0; row < now.size(); ++row) {
            const motion::KinematicState& s = now[row].state;
            entities_.position[row] = s.position;
            entities_.orientation[row] = s.orientation;
            entities_.velocity[row] = s.velocity;
            entities_.acceleration[row] = s.acceleration;
            entities_.angular_velocity[row] = s.angular_velocity;
            entities_.set(row, world::kAtRest, now[row].at_rest);
        }
        packets_.clear();
        const world::Visibility visibility{visible_};
        const replication::Report report =
            replicator_.step(tick_, ZoneId(1), entities_, types_, visibility, {}, packets_);
        publications_ += report.publications;
        bytes_ += report.bytes;
        if (!packets_.empty()) {
            replicator_.on_acks({kWatcher, packets_.back().sequence, ~0U, 1000});
        }
    }

    void observe() override {
        view_.evaluate(tick_ - 1);
        for (mailbox::StatePacket& packet : packets_) {
            under_way_.emplace_back(tick_ + delay_, std::move(packet));
        }
        for (; !under_way_.empty() && under_way_.front().first <= tick_; under_way_.pop_front()) {
            const mailbox::StatePacket& packet = under_way_.front().second;
            const auto parsed = wire::read_down_head(packet.body);
            const auto records =
                std::span<const std::uint8_t>(packet.body).subspan(parsed->records_offset);
            view_.apply({packet.sequence, parsed->head, records}, 0.0);
        }
        view_.evaluate(tick_);
        // An interpolating view is compared at the tick that it displays.
        const Tick displayed = view_.displayed_tick();
        if (displayed < 1) {
            return;
        }
        const std::vector<TracedState>& then =
            trace_.frames[static_cast<std::size_t>(displayed - 1)];
        for (std::size_t i = 0; i < then.size(); ++i) {
            compare(i, displayed, then[i]);
        }
    }

    void judge(Row& row) override {
        const double seconds = static_cast<double>(tick_) * static_cast<double>(trace_.tick_s);
        row.error = predicted_.rms();
        row.error_unit = std::string("m");
        row.metric("updates_per_s", static_cast<double>(publications_) / seconds);
        row.metric("bytes_per_s", static_cast<double>(bytes_) / seconds);
        row.metric("rms_m", row.error);
        row.metric("max_m", predicted_.largest);
        row.metric("displayed_rms_m", displayed_.rms());
        row.metric("displayed_max_m", displayed_.largest);
        row.metric("jerk_mps3", jerk_.rms());
        row.metric("delay_ticks", static_cast<double>(view_.delay()));
        const auto published = static_cast<double>(std::max<std::uint64_t>(view_.stats().shown, 1));
        constexpr std::array<const char*, motion::kPredictorOrders> kKinds{
            "order0_share", "order1_share", "order2_share", "ballistic_share", "turning_share"};
        for (std::size_t kind = 0; kind < kKinds.size(); ++kind) {
            row.metric(kKinds[kind], static_cast<double>(view_.stats().by_order[kind]) / published);
        }
        row.metric("moving_share",
                   static_cast<double>(predicted_.count) /
                       (static_cast<double>(tick_) * static_cast<double>(shown_.size())));
    }

  private:
    /// Displayed positions of the last ticks, newest last.
    struct Shown {
        std::array<Vec3d, 4> places{};
        int known = 0;
    };

    void compare(std::size_t index, Tick tick, const TracedState& truth) {
        const view::Entity* entity =
            view_.store().find(EntityId(static_cast<std::uint32_t>(index + 1)));
        const view::Version* version =
            entity != nullptr ? view_.held(*entity, tick, tick_) : nullptr;
        Shown& shown = shown_[index];
        if (version == nullptr || !version->present || truth.at_rest) {
            shown.known = 0;
            return;
        }
        const Vec3d real = truth.state.position.cast<double>();
        const Vec3d seen = view_.displayed(*entity, *version, tick, tick_).position;
        predicted_.add((view_.store().predicted(*version, tick).position - real).norm());
        displayed_.add((seen - real).norm());
        std::rotate(shown.places.begin(), shown.places.begin() + 1, shown.places.end());
        shown.places[3] = seen;
        if (++shown.known >= 4) {
            const auto& p = shown.places;
            const double tick_s = static_cast<double>(trace_.tick_s);
            jerk_.add((p[3] - 3.0 * p[2] + 3.0 * p[1] - p[0]).norm() / (tick_s * tick_s * tick_s));
        }
    }

    const MotionTrace& trace_;
    Tick delay_ = 0;
    replication::Settings settings_;
    world::TypeTable types_;
    replication::Replicator replicator_;
    view::View view_;
    world::Entities entities_;
    world::VisibleSet visible_;
    std::vector<mailbox::StatePacket> packets_;
    std::deque<std::pair<Tick, mailbox::StatePacket>> under_way_;  // when it comes
    std::vector<Shown> shown_;
    Tick tick_ = 0;
    std::uint64_t publications_ = 0;
    std::uint64_t bytes_ = 0;
    Figure predicted_;
    Figure displayed_;
    Figure jerk_;
};

std::string parameter_of(float threshold_m, const std::string& motion) {
    char text[80];
    std::snprintf(text,
                  sizeof text,
                  "threshold=%g motion=%s",
                  static_cast<double>(threshold_m),
                  motion.c_str());
    return text;
}

void run_trace(Session& session, const MotionTrace& trace) {
    if (trace.frames.empty()) {
        return;
    }
    const std::vector<float> thresholds =
        session.quick ? std::vector<float>{0.05F} : std::vector<float>{0.01F, 0.05F, 0.2F, 1.0F};
    std::vector<Row> rows;
    for (const float threshold : thresholds) {
        std::vector<Method> methods;
        for (const Predictor& predictor : kPredictors) {
            methods.push_back({predictor.name, "", [&trace, threshold, predictor] {
                                   return std::make_unique<ReckoningTrial>(
                                       trace, threshold, predictor.forced, kWatchers[0], 0);
                               }});
        }
        for (Row& row : compare("replication",
                                "dead_reckoning",
                                parameter_of(threshold, trace.motion),
                                wanted(session, std::move(methods)),
                                {0, static_cast<int>(trace.frames.size()), 1})) {
            rows.push_back(std::move(row));
        }
    }
    // A curve per method: its points follow each other.
    std::vector<Row> curves;
    for (const Predictor& predictor : kPredictors) {
        std::copy_if(rows.begin(), rows.end(), std::back_inserter(curves), [&](const Row& row) {
            return row.method == predictor.name;
        });
    }
    session.add(std::move(curves));
}

/// News is a tenth of a second old: what each way of displaying costs in error and jerk.
void run_display(Session& session, const MotionTrace& trace) {
    if (trace.frames.empty()) {
        return;
    }
    const Tick delay = std::lround(0.1 / static_cast<double>(trace.tick_s));
    std::vector<Method> methods;
    for (const Watcher& watcher : kWatchers) {
        methods.push_back({watcher.name, "", [&trace, watcher, delay] {
                               return std::make_unique<ReckoningTrial>(
                                   trace, 0.05F, -1, watcher, delay);
                           }});
    }
    session.add(compare("replication",
                        "display",
                        "threshold=0.05 motion=" + trace.motion,
                        wanted(session, std::move(methods)),
                        {0, static_cast<int>(trace.frames.size()), 1}));
}

}  // namespace

void run_dead_reckoning(Session& session) {
    const int seconds = session.quick ? 2 : 20;
    const auto run = [&session](const MotionTrace& trace) {
        if (session.wants_scene("dead_reckoning")) {
            run_trace(session, trace);
        }
        if (session.wants_scene("display")) {
            run_display(session, trace);
        }
    };
    run(orbit_trace(100, 30 * seconds));
    run(throw_trace(100, 30 * seconds));
    run(walk_trace(100, 30 * seconds));
    run(valley_trace(true, 100, 30 * seconds));
    run(valley_trace(false, 100, 30 * seconds));
    for (const char* which : {"A", "B"}) {
        std::string why;
        // A recording of 47 s: the first 15 are enough of it.
        run(cubes_trace(which, 60 * (session.quick ? 1 : 15), why));
        if (!why.empty()) {
            session.note(why);
        }
    }
    session.note(
        "dead_reckoning: all of the scene's entities together, to one client without delay; errors "
        "of the prediction (displayed_: of what is displayed) and jerk of what is displayed, at "
        "the "
        "ticks and of what moves. display: the same with news that is 100 ms old; an interpolating "
        "view is compared at the tick that it displays");
}

}  // namespace zoned::bench
