#include "server/zone/simulation/type_body.h"

namespace zoned::zone {

namespace {

physics::Shape shape_of(const world::EntityType& type, std::span<const physics::Shape> solids) {
    switch (type.shape) {
        case world::TypeShape::kSphere:
            return physics::Shape::sphere(type.radius);
        case world::TypeShape::kBox:
        case world::TypeShape::kSoft:
            return physics::Shape::box(type.half_extents);
        case world::TypeShape::kCapsule:
            return physics::Shape::capsule(type.radius, type.half_segment);
        case world::TypeShape::kSolid:
            return solids[type.solid];
    }
    return {};
}

}  // namespace

physics::Filter filter_of(const world::EntityType& type) {
    physics::Filter filter;
    if (type.rewindable) {
        filter.category = kRewindableCategory;
    }
    if (type.assembly != 0) {
        filter.category = type.rewindable ? kRewindablePartCategory : kPartCategory;
    } else if (type.kind == world::EntityKind::kCharacter) {
        filter.mask = ~(kRewindablePartCategory | kPartCategory);
    }
    return filter;
}

physics::BodyDef body_of(const world::EntityType& type, std::span<const physics::Shape> solids) {
    physics::BodyDef def;
    def.kind = type.kind == world::EntityKind::kProp ? physics::BodyKind::kDynamic
                                                     : physics::BodyKind::kKinematic;
    def.shape = shape_of(type, solids);
    def.material = {type.friction, type.restitution};
    def.material.rolling_m = type.rolling_m;
    def.material.spinning_m = type.spinning_m;
    def.mass = type.mass;
    def.inertia = type.inertia;
    def.damping = {type.drag, type.angular_drag};
    def.filter = filter_of(type);
    return def;
}

}  // namespace zoned::zone
