#include "tests/web/motion_bits.h"

#include "tests/scenario/elementary_bits.h"
#include "shared/core/rng.h"
#include "shared/motion/apply_input.h"
#include "shared/motion/convergence.h"
#include "shared/motion/dead_reckoning.h"
#include "shared/motion/ground_surface.h"
#include "shared/wire/publication.h"
#include "shared/wire/quantize.h"

#include <cmath>
#include <cstdint>
#include <memory>

namespace zoned::testing_web {

namespace {

using namespace motion;

constexpr float kDt = 1.0F / 30.0F;
constexpr int kTicks = 3000;

Vec3 random_vector(core::Rng& rng, float size) {
    const float x = rng.unit();
    const float y = rng.unit();
    const float z = rng.unit();
    return size * Vec3(2.0F * x - 1.0F, 2.0F * y - 1.0F, 2.0F * z - 1.0F);
}

/// Of unit length.
Quat random_turn(core::Rng& rng) {
    const Vec3 v = random_vector(rng, 1.0F);
    const float length = std::sqrt(1.0F + v.x() * v.x() + v.y() * v.y() + v.z() * v.z());
    return {1.0F / length, v.x() / length, v.y() / length, v.z() / length};
}

std::vector<StaticBox> boxes(core::Rng& rng) {
    std::vector<StaticBox> out;
    for (int i = 0; i < 60; ++i) {
        StaticBox box;
        box.centre = random_vector(rng, 20.0F);
        box.centre.y() = rng.unit();
        box.half_extents = Vec3(0.3F, 0.1F, 0.3F);
        box.half_extents.x() += 2.0F * rng.unit();
        box.half_extents.y() += rng.unit();
        box.half_extents.z() += 2.0F * rng.unit();
        if (i % 2 == 0) {
            box.orientation = random_turn(rng);
        }
        out.push_back(box);
    }
    return out;
}

StaticSurface hills(core::Rng& rng) {
    const auto heights = std::make_shared<std::vector<float>>(41 * 41);
    for (float& height : *heights) {
        height = 1.5F * rng.unit();
    }
    HeightGrid grid;
    grid.heights = *heights;
    grid.columns = 41;
    grid.rows = 41;
    grid.spacing_x = grid.spacing_z = 1.0F;
    grid.thickness = 1.0F;
    StaticSurface out;
    out.surface = std::make_shared<const Surface>(grid, heights);
    return out;
}

std::vector<Door> doors() {
    std::vector<Door> out;
    for (int i = 0; i < 8; ++i) {
        Door door;
        door.box.centre =
            Vec3(static_cast<float>(i) - 4.0F, 1.0F, static_cast<float>(i % 3) - 1.0F);
        door.box.half_extents = Vec3(0.6F, 1.0F, 0.1F);
        door.times.period = 60 + 7 * i;
        door.times.open = {{0, 30}};
        out.push_back(door);
    }
    return out;
}

std::vector<Platform> platforms() {
    std::vector<Platform> out;
    for (int i = 0; i < 6; ++i) {
        Platform platform;
        platform.box.centre =
            Vec3(2.0F * static_cast<float>(i) - 5.0F, 0.5F, static_cast<float>(i % 3) - 1.0F);
        platform.box.half_extents = Vec3(1.5F, 0.2F, 1.5F);
        platform.path.stops = {{Vec3::Zero(), 0},
                               {Vec3(0.0F, 2.0F, 1.0F), 40 + 7 * i},
                               {Vec3(-3.0F, 1.0F, 2.0F), 100 + 5 * i}};
        platform.path.back = i % 2 == 0 ? 0 : 60;
        platform.path.wait = 10;
        out.push_back(platform);
    }
    return out;
}

std::vector<float> walk(const StaticGeometry& world, core::Rng& rng) {
    std::vector<float> out;
    CharacterState state;
    state.position = Vec3(0.0F, 4.0F, 0.0F);
    InputCommand command;
    for (Tick tick = 1; tick <= kTicks; ++tick) {
        if (tick % 15 == 1) {
            command.move_x = static_cast<std::int8_t>(254.0F * rng.unit() - 127.0F);
            command.move_z = static_cast<std::int8_t>(254.0F * rng.unit() - 127.0F);
            command.yaw = static_cast<std::uint16_t>(65535.0F * rng.unit());
            command.buttons = static_cast<std::uint16_t>(4.0F * rng.unit());
        }
        command.tick = tick;
        state = apply_input(state, command, {}, world, kDt, tick);
        for (int axis = 0; axis < 3; ++axis) {
            out.push_back(state.position[axis]);
            out.push_back(state.velocity[axis]);
        }
        out.push_back(state.grounded ? 1.0F : 0.0F);
        if (state.position.norm() > 30.0F) {
            state.position = Vec3(0.0F, 4.0F, 0.0F);
        }
    }
    return out;
}

KinematicState random_motion(core::Rng& rng) {
    KinematicState state;
    state.position = random_vector(rng, 100.0F);
    state.orientation = random_turn(rng);
    state.velocity = random_vector(rng, 12.0F);
    state.acceleration = random_vector(rng, 20.0F);
    state.angular_velocity = random_vector(rng, 4.0F);
    state.turn = random_vector(rng, 3.0F);
    state.floor = state.position.y() - 5.0F * rng.unit();
    return state;
}

void put(std::vector<float>& out, const Vec3& v) {
    out.insert(out.end(), {v.x(), v.y(), v.z()});
}

std::vector<float> positions(PredictorOrder order, core::Rng& rng) {
    std::vector<float> out;
    for (int i = 0; i < kTicks; ++i) {
        KinematicState from = random_motion(rng);
        if (order == PredictorOrder::kBallistic) {
            from.acceleration = Vec3(0.0F, -9.81F, 0.0F);
        }
        put(out, predict_position(from, order, 2.0F * rng.unit()));
    }
    return out;
}

std::vector<float> landings(core::Rng& rng) {
    std::vector<float> out;
    for (int i = 0; i < kTicks; ++i) {
        KinematicState from = random_motion(rng);
        from.acceleration = Vec3(0.0F, -9.81F, 0.0F);
        out.push_back(landing_time(from));
    }
    return out;
}

std::vector<float> blends(ConvergenceMethod method, core::Rng& rng) {
    std::vector<float> out;
    for (int i = 0; i < kTicks; ++i) {
        const KinematicState shown = random_motion(rng);
        const KinematicState predicted = random_motion(rng);
        Convergence convergence;
        convergence.begin(shown, predicted, 0.2F);
        put(out, convergence.display(method, predicted, 0.25F * rng.unit()).position);
    }
    return out;
}

/// Whole numbers, and the bytes of their records.
std::vector<float> quantised(core::Rng& rng) {
    std::vector<float> out;
    const wire::Quantization q;
    std::vector<std::uint8_t> bytes;
    for (int i = 0; i < kTicks; ++i) {
        KinematicState state = random_motion(rng);
        state.orientation = Quat::Identity();
        state.angular_velocity = Vec3::Zero();
        const wire::QuantizedState steps =
            wire::quantize(state, PredictorOrder::kQuadratic, false, false, 7, q);
        wire::RecordHead head;
        head.entity = EntityId(static_cast<std::uint32_t>(i) + 1);
        bytes.clear();
        wire::encode_absolute(head, steps, false, q, bytes);
        out.insert(out.end(), bytes.begin(), bytes.end());
        put(out, wire::dequantize(steps, false, q).position);
    }
    return out;
}

std::vector<float> orientations(core::Rng& rng) {
    std::vector<float> out;
    for (int i = 0; i < kTicks; ++i) {
        const KinematicState from = random_motion(rng);
        const Quat q = predict_orientation(from, PredictorOrder::kLinear, 2.0F * rng.unit());
        out.insert(out.end(), {q.w(), q.x(), q.y(), q.z()});
    }
    return out;
}

std::vector<float> blended_turns(core::Rng& rng) {
    std::vector<float> out;
    for (int i = 0; i < kTicks; ++i) {
        const KinematicState shown = random_motion(rng);
        const KinematicState predicted = random_motion(rng);
        Convergence convergence;
        convergence.begin(shown, predicted, 0.2F);
        const KinematicState state =
            convergence.display(ConvergenceMethod::kHermite, predicted, 0.2F * rng.unit());
        const Quat& q = state.orientation;
        out.insert(out.end(), {q.w(), q.x(), q.y(), q.z()});
        put(out, state.angular_velocity);
        out.push_back(angle_between(shown.orientation, predicted.orientation));
    }
    return out;
}

/// Turns about y as whole numbers and back.
std::vector<float> upright(core::Rng& rng) {
    std::vector<float> out;
    const wire::Quantization q;
    for (int i = 0; i < kTicks; ++i) {
        const wire::QuantizedState steps =
            wire::quantize(random_motion(rng), PredictorOrder::kLinear, true, false, 0, q);
        out.push_back(static_cast<float>(steps.orientation[0]));
        const Quat turn = wire::dequantize(steps, true, q).orientation;
        out.insert(out.end(), {turn.w(), turn.y()});
        const Quat yaw = orientation_from_yaw(static_cast<std::uint16_t>(rng.next()));
        out.insert(out.end(), {yaw.w(), yaw.y()});
    }
    return out;
}

/// Each hash in pieces that a float holds.
std::vector<float> elementary_hashes() {
    std::vector<float> out;
    for (const scenario::ElementarySubject& subject : scenario::kElementarySubjects) {
        const std::uint64_t bits = scenario::elementary_bits(subject);
        for (int piece = 0; piece < 4; ++piece) {
            out.push_back(static_cast<float>(bits >> (16 * piece) & 0xffffU));
        }
    }
    return out;
}

}  // namespace

std::vector<float> numbers_of(std::size_t subject) {
    core::Rng rng(7 + subject);
    switch (subject) {
        case 0:
            return walk(StaticGeometry(boxes(rng), 0.0F), rng);
        case 1:
            return walk(StaticGeometry({}, -1.0F, kStaticCell_m, {hills(rng)}), rng);
        case 2:
            return walk(StaticGeometry({}, 0.0F, kStaticCell_m, {}, doors()), rng);
        case 3:
            return positions(PredictorOrder::kStatic, rng);
        case 4:
            return positions(PredictorOrder::kLinear, rng);
        case 5:
            return positions(PredictorOrder::kQuadratic, rng);
        case 6:
            return positions(PredictorOrder::kBallistic, rng);
        case 7:
            return landings(rng);
        case 8:
            return blends(ConvergenceMethod::kSnap, rng);
        case 9:
            return blends(ConvergenceMethod::kLinear, rng);
        case 10:
            return blends(ConvergenceMethod::kProjectiveVelocity, rng);
        case 11:
            return blends(ConvergenceMethod::kHermite, rng);
        case 12:
            return quantised(rng);
        case 13:
            return positions(PredictorOrder::kTurning, rng);
        case 14:
            return orientations(rng);
        case 15:
            return blended_turns(rng);
        case 16:
            return upright(rng);
        case 17:
            return elementary_hashes();
        default:
            return walk(StaticGeometry(boxes(rng), 0.0F, kStaticCell_m, {}, {}, platforms()), rng);
    }
}

}  // namespace zoned::testing_web
