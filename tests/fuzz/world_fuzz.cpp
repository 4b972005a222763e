// Fuzzing of the description of a world that a server sends at login: what a client accepts it can
// display and walk in.
#include "client-sim/view/view.h"
#include "tests/fuzz/fuzz.h"
#include "tests/unit/client/fake_server.h"
#include "shared/core/assert.h"

namespace zoned::fuzz {

namespace {

/// A box, a door, a platform, a slope, a triangle, smoke, a clock, a variable and a soft body.
proto::WorldDescription furnished() {
    test::FakeServer server;
    server.sparks = true;
    proto::WorldDescription w = server.world();
    proto::Door& door = *w.add_doors();
    door.set_period(30);
    door.add_open(10);
    door.add_open(20);
    proto::Platform& platform = *w.add_platforms();
    for (const float offset : {0.0F, 0.0F, 0.0F, -3.0F, 2.0F, 0.0F}) {
        platform.add_offsets(offset);
    }
    platform.add_ticks(0);
    platform.add_ticks(20);
    for (proto::StaticBox* box : {w.add_boxes(), door.mutable_box(), platform.mutable_box()}) {
        for (int axis = 0; axis < 3; ++axis) {
            box->add_centre(3.0F);
            box->add_half_extents(1.0F);
        }
    }
    for (int i = 0; i < 2; ++i) {
        w.add_surfaces()->mutable_position()->Resize(3, 0.0);
    }
    proto::StaticSurface::Heights& heights = *w.mutable_surfaces(0)->mutable_heights();
    heights.set_columns(2);
    heights.set_rows(2);
    heights.set_spacing_x(4.0F);
    heights.set_spacing_z(4.0F);
    heights.mutable_height()->Resize(4, 0.5F);
    proto::StaticSurface::Triangles& triangles = *w.mutable_surfaces(1)->mutable_triangles();
    for (const float n : {0.0F, 0.0F, 0.0F, 0.0F, 0.0F, 5.0F, 5.0F, 1.0F, 0.0F}) {
        triangles.add_vertex(n);
    }
    for (const std::uint32_t corner : {0U, 1U, 2U}) {
        triangles.add_corner(corner);
    }
    proto::EntityType& soft = *w.mutable_types(0);
    proto::Deformation& deformation = *soft.mutable_deformation();
    for (const std::uint32_t points : {2U, 2U, 1U}) {
        deformation.add_points(points);
        deformation.add_lower(-1.0F);
        deformation.add_upper(1.0F);
    }
    deformation.set_quantum_m(0.02F);
    deformation.set_bound_m(0.05F);
    for (int point = 0; point < 4; ++point) {
        proto::DeclaredField& field = *soft.add_fields();
        field.set_name("control_point_" + std::to_string(point));
        field.set_quantum(1.0);
        field.set_steps(wire::kMostFieldSteps);
        field.add_initial(wire::DeformationLattice::kUndisplaced);
    }
    w.add_shared_clocks()->set_period(24.0);
    proto::SharedVariable::Phase& phase = *w.add_shared_variables()->add_phases();
    phase.set_weight(1.0);
    phase.set_min_s(1.0);
    phase.set_max_s(2.0);
    return w;
}

/// Any place is displaced by no more than the range of a code.
void deform(const view::View& view) {
    const view::WorldInfo& world = view.world();
    for (std::size_t t = 0; t < world.types.size(); ++t) {
        if (const auto& lattice = world.types[t].deformation) {
            const wire::FieldSchema& fields =
                *wire::schema_of(world.fields, static_cast<TypeIndex>(t));
            const std::size_t first = fields.fields()[world.types[t].first_control_point].word;
            const Vec3 moved = lattice->displacement_at(
                lattice->weights_at(Vec3(0.3F, -9.0F, 1e9F)), fields.initial().subspan(first));
            ZONED_ASSERT(moved.cwiseAbs().maxCoeff() <= 129.0F * lattice->quantum_m,
                         "a displacement is within the range of its code");
        }
    }
}

/// A second of a walk in all directions, from a state that the server gave.
void walk(view::View& view) {
    wire::OwnState own;
    own.avatar = EntityId(9);
    own.input_tick = 10;
    own.state.position = Vec3(1.0F, 2.0F, 1.0F);
    view.own().reconcile(own, view.world().zones.front().id);
    for (Tick tick = 11; tick < 41; ++tick) {
        motion::InputCommand command;
        command.tick = tick;
        command.move_x = static_cast<std::int8_t>(tick % 2 == 0 ? 127 : -127);
        command.move_z = 127;
        view.own().push(command);
        view.evaluate(tick);
    }
    view.maintain(1.0);
}

}  // namespace

std::vector<Bytes> seeds() {
    std::vector<Bytes> all;
    for (const proto::WorldDescription& w : {test::FakeServer().world(), furnished()}) {
        const std::string bytes = w.SerializeAsString();
        all.emplace_back(bytes.begin(), bytes.end());
    }
    return all;
}

}  // namespace zoned::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace zoned;
    wire::WorldDescriptionMessage description;
    if (!wire::decode_message(std::span(data, size), description)) {
        return 0;
    }
    auto world = view::read_world(description);
    if (!world) {
        return 0;
    }
    view::View view(std::make_shared<const view::WorldInfo>(std::move(*world)), {}, nullptr);
    fuzz::walk(view);
    fuzz::deform(view);
    std::vector<motion::CosmeticParticle> smoke;
    for (const view::CosmeticInfo& system : view.world().cosmetics) {
        for (const motion::CosmeticEmitter& emitter : system.emitters) {
            if (emitter.emitter.rate_hz < 1e4) {
                motion::replay(emitter, view.tick(), view.world().tick_s, smoke);
            }
        }
    }
    return 0;
}
