#include "tests/bench/comparison.h"
#include "tests/bench/motion_traces.h"
#include "tests/bench/suite_replication.h"
#include "tests/bench/traced_zone.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <iterator>

namespace zoned::bench {

namespace {

constexpr float kOrientationBound = 0.1F;
constexpr double kHeartbeatS = 2.0;

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

/// How a client displays the entities that it hears of.
struct Watcher {
    const char* name;
    view::ViewKind kind = view::ViewKind::kExtrapolate;
    motion::ConvergenceMethod convergence = motion::ConvergenceMethod::kProjectiveVelocity;
    view::DisplayedState displayed_state = view::DisplayedState::kPredicted;
};

constexpr std::array<Watcher, 6> kWatchers{
    {{"default"},
     {"snap", view::ViewKind::kExtrapolate, motion::ConvergenceMethod::kSnap},
     {"linear", view::ViewKind::kExtrapolate, motion::ConvergenceMethod::kLinear},
     {"hermite", view::ViewKind::kExtrapolate, motion::ConvergenceMethod::kHermite},
     {"unpredicted",
      view::ViewKind::kExtrapolate,
      motion::ConvergenceMethod::kProjectiveVelocity,
      view::DisplayedState::kPublished},
     {"interpolate", view::ViewKind::kInterpolate}}};

/// One level of detail with the threshold for its bound.
replication::ReplicationSettings settings_for(const MotionTrace& trace,
                                              float threshold_m,
                                              int forced) {
    replication::ReplicationSettings s =
        settings_for_bound(trace, {threshold_m, kOrientationBound}, kHeartbeatS);
    s.forced_order = forced;
    return s;
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
          settings_(settings_for(trace, threshold_m, forced)),
          zone_(trace, settings_, {1, false, delay}),
          client_(
              trace,
              settings_,
              view::ViewSettings{watcher.convergence, false, watcher.kind, watcher.displayed_state},
              delay),
          shown_(trace.frames.front().size()) {}

    void frame() override {
        const replication::ReplicationReport& report = zone_.step();
        publications_ += report.publications;
        bytes_ += report.bytes;
    }

    void observe() override {
        for (const mailbox::StatePacket& packet : zone_.packets()) {
            client_.take(zone_.tick(), packet);
        }
        client_.display(zone_.tick());
        // An interpolating view is compared at the tick that it displays.
        const Tick displayed = client_.view().displayed_tick();
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
        const double seconds =
            static_cast<double>(zone_.tick()) * static_cast<double>(trace_.tick_s);
        row.error = predicted_.rms();
        row.error_unit = std::string("m");
        row.metric("updates_per_s", static_cast<double>(publications_) / seconds);
        row.metric("bytes_per_s", static_cast<double>(bytes_) / seconds);
        row.metric("rms_m", row.error);
        row.metric("max_m", predicted_.largest);
        row.metric("displayed_rms_m", displayed_.rms());
        row.metric("displayed_max_m", displayed_.largest);
        row.metric("jerk_mps3", jerk_.rms());
        row.metric("delay_ticks", static_cast<double>(client_.view().delay()));
        const auto published =
            static_cast<double>(std::max<std::uint64_t>(client_.view().stats().shown, 1));
        constexpr std::array<const char*, motion::kPredictorOrders> kKinds{
            "order0_share", "order1_share", "order2_share", "ballistic_share", "turning_share"};
        for (std::size_t kind = 0; kind < kKinds.size(); ++kind) {
            row.metric(kKinds[kind],
                       static_cast<double>(client_.view().stats().by_order[kind]) / published);
        }
        row.metric("moving_share",
                   static_cast<double>(predicted_.count) /
                       (static_cast<double>(zone_.tick()) * static_cast<double>(shown_.size())));
    }

  private:
    /// Displayed positions of the last ticks, newest last.
    struct Shown {
        std::array<Vec3d, 4> places{};
        int known = 0;
    };

    void compare(std::size_t index, Tick tick, const TracedState& truth) {
        const view::Entity* entity =
            client_.view().store().find(EntityId(static_cast<std::uint32_t>(index + 1)));
        const view::Version* version =
            entity != nullptr ? client_.view().held(*entity, tick, zone_.tick()) : nullptr;
        Shown& shown = shown_[index];
        if (version == nullptr || !version->present || truth.at_rest) {
            shown.known = 0;
            return;
        }
        const Vec3d real = truth.state.position.cast<double>();
        const Vec3d seen = client_.view().displayed(*entity, *version, tick, zone_.tick()).position;
        predicted_.add((client_.view().store().predicted(*version, tick).position - real).norm());
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
    replication::ReplicationSettings settings_;
    TracedZone zone_;
    TracedClient client_;
    std::vector<Shown> shown_;
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

/// Updates are a tenth of a second old: the error and jerk of each display method.
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
