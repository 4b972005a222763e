#include "server/replication/packer.h"
#include "tests/bench/comparison.h"
#include "tests/bench/suite_replication.h"
#include "tests/bench/traced_zone.h"
#include "shared/core/rng.h"

#include <algorithm>
#include <cmath>

namespace zoned::bench {

namespace {

/// IPv4 and UDP headers; the other overhead of a body is inside the datagram.
constexpr std::size_t kIpAndUdpBytes = 28;

/// Every `step`-th tick of a trace: the same motion at a lower rate.
MotionTrace thinned(const MotionTrace& trace, int step) {
    MotionTrace out = trace;
    out.tick_s = trace.tick_s * static_cast<float>(step);
    out.frames.clear();
    for (std::size_t i = 0; i < trace.frames.size(); i += static_cast<std::size_t>(step)) {
        out.frames.push_back(trace.frames[i]);
    }
    return out;
}

/// The client's prediction, against the truth of the trace.
struct Accuracy {
    double position_m = 0.0;  ///< largest
    double component = 0.0;   ///< largest difference of a quaternion's component
    double orientation_rad = 0.0;

    void compare(const view::View& view,
                 Tick tick,
                 const std::vector<TracedState>& truth,
                 EntityId own) {
        for (std::size_t i = 0; i < truth.size(); ++i) {
            const EntityId id(static_cast<std::uint32_t>(i + 1));
            const view::Entity* entity = view.store().find(id);
            if (id == own || entity == nullptr || !entity->present()) {
                continue;
            }
            const view::WorldState seen = view.store().predicted(entity->versions.back(), tick);
            const motion::KinematicState& real = truth[i].state;
            position_m =
                std::max(position_m, (seen.position - real.position.cast<double>()).norm());
            const Eigen::Vector4f a = seen.orientation.coeffs();
            const Eigen::Vector4f b = real.orientation.coeffs();
            const float nearer =
                std::min((a - b).cwiseAbs().maxCoeff(), (a + b).cwiseAbs().maxCoeff());
            component = std::max(component, static_cast<double>(nearer));
            orientation_rad =
                std::max(orientation_rad,
                         static_cast<double>(seen.orientation.angularDistance(real.orientation)));
        }
    }
};

/// A trace to some clients; a frame is one step of the replicator for all of them.
class SceneTrial : public JudgedTrial {
  public:
    SceneTrial(const MotionTrace& trace,
               const replication::ReplicationSettings& settings,
               const TracedZone::Plan& plan)
        : trace_(trace),
          own_(plan.avatars ? 1 : 0),
          zone_(trace, settings, plan),
          client_(trace, settings, {}, 0) {}

    void frame() override { report_ = zone_.step(); }

    void observe() override {
        if (zone_.tick() == kSettled) {
            payload_bytes_ = wire_bytes_ = body_bytes_ = updates_ = 0;
        }
        updates_ += report_.records_sent;
        for (std::size_t i = 0; i < zone_.packets().size(); ++i) {
            const mailbox::StatePacket& packet = zone_.packets()[i];
            const std::size_t wire = packet.body.size() + replication::kPacketOverheadBytes;
            wire_bytes_ += wire;
            payload_bytes_ += wire - kIpAndUdpBytes;
            body_bytes_ += packet.body.size();
            if (packet.client == ClientId(1) && zone_.arrives(i)) {
                client_.take(zone_.tick(), packet);
            }
        }
        client_.display(zone_.tick());
        accuracy_.compare(client_.view(),
                          zone_.tick(),
                          trace_.frames[static_cast<std::size_t>(zone_.tick() - 1)],
                          own_);
    }

    void judge(Row& row) override {
        const double seconds =
            static_cast<double>(zone_.tick() - kSettled) * static_cast<double>(trace_.tick_s);
        row.error = accuracy_.position_m;
        row.error_unit = std::string("m");
        row.metric("body_kbit_per_s", 0.008 * static_cast<double>(body_bytes_) / seconds);
        row.metric("payload_bytes_per_s", static_cast<double>(payload_bytes_) / seconds);
        row.metric("wire_bytes_per_s", static_cast<double>(wire_bytes_) / seconds);
        row.metric("updates_per_s", static_cast<double>(updates_) / seconds);
        row.metric("max_m", accuracy_.position_m);
        row.metric("max_quaternion_component", accuracy_.component);
        row.metric("max_rad", accuracy_.orientation_rad);
        row.metric("present", static_cast<double>(client_.view().store().present_count()));
    }

  private:
    /// Joining is no steady state.
    static constexpr Tick kSettled = 30;

    const MotionTrace& trace_;
    EntityId own_;
    TracedZone zone_;
    TracedClient client_;
    replication::ReplicationReport report_;
    std::uint64_t payload_bytes_ = 0;
    std::uint64_t wire_bytes_ = 0;
    std::uint64_t body_bytes_ = 0;
    std::uint64_t updates_ = 0;
    Accuracy accuracy_;
};

void run_scene(Session& session,
               const std::string& scene,
               const MotionTrace& trace,
               const replication::ReplicationSettings& settings,
               const TracedZone::Plan& plan,
               const std::string& parameter = "") {
    if (!session.wants_scene(scene)) {
        return;
    }
    session.progress("replication " + scene);
    const auto with = [&](const char* name, replication::Codec codec) {
        return Method{name, "", [&trace, &plan, settings, codec] {
                          replication::ReplicationSettings s = settings;
                          s.codec = codec;
                          return std::make_unique<SceneTrial>(trace, s, plan);
                      }};
    };
    session.add(
        compare("replication",
                scene,
                parameter,
                wanted(session,
                       {with("default", replication::Codec::kShared),
                        with("per_client", replication::Codec::kPerClient),
                        with("auto", replication::Codec::kAuto)}),
                {0, static_cast<int>(trace.frames.size()), session.quick ? 1 : session.repeats}));
}

/// The published task: positions to a hundredth of a metre, components of quaternions to a
/// thousandth. A component changes by half the angle at most.
void run_many_bodies(Session& session) {
    const MotionTrace trace = orbit_trace(250, session.quick ? 60 : 1800);
    replication::ReplicationSettings settings = settings_for_bound(trace, {0.01F, 0.002F}, 8.0);
    settings.quantization.orientation_bits = 13;
    run_scene(session, "bodies250", trace, settings, {1, false, 0});
}

void run_crowds(Session& session) {
    const int seconds = session.quick ? 4 : 60;
    const MotionTrace walk = thinned(walk_trace(200, 30 * seconds), 3);
    replication::ReplicationSettings settings = settings_for_bound(walk, {0.05F, 0.1F}, 2.0);
    settings.own_state_every_ticks = 2;
    settings.silence_ticks = 5;
    run_scene(session, "crowd200", walk, settings, {200, true, 0});
    const MotionTrace crowd = walk_trace(100, 30 * (session.quick ? 2 : 20));
    run_scene(
        session, "crowd100", crowd, settings_for_bound(crowd, {0.05F, 0.1F}, 2.0), {100, true, 0});
}

/// Every cube within half a quantum at every tick: no prediction, so a cube is sent when its
/// quantised place or orientation is another one.
void run_cubes(Session& session, const std::string& which) {
    std::string why;
    const MotionTrace cubes = cubes_trace(which, session.quick ? 300 : 2833, why);
    if (cubes.frames.empty()) {
        session.note(why);
        return;
    }
    replication::ReplicationSettings settings = settings_for_bound(cubes, {1.0F, 1.0F}, 4.0);
    settings.forced_order = static_cast<int>(motion::PredictorOrder::kStatic);
    settings.quantization.position_step_m = 1.0F / 512.0F;
    settings.quantization.orientation_bits = 9;
    settings.quantization.horizontal_extent_m = 32.0F;
    settings.quantization.vertical_extent_m = 16.0F;
    settings.lods = {{settings.quantization.position_quantum_m(),
                      settings.quantization.orientation_quantum_rad(false)}};
    constexpr Tick kDelay = 3;
    run_scene(session, "cubes901_" + which, cubes, settings, {1, false, kDelay, 0.0});
    run_scene(session, "cubes901_" + which, cubes, settings, {1, false, kDelay, 0.05}, "loss 5 %");
}

}  // namespace

void run_scenes(Session& session) {
    for (const char* which : {"A", "B"}) {
        if (session.wants_scene(std::string("cubes901_") + which)) {
            run_cubes(session, which);
        }
    }
    if (session.wants_scene("bodies250")) {
        run_many_bodies(session);
    }
    if (session.wants_scene("crowd200") || session.wants_scene("crowd100")) {
        run_crowds(session);
    }
}

}  // namespace zoned::bench
