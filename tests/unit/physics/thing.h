// Thing: a shape at a place, for tests that let two of them meet.
#pragma once

#include "server/physics/narrowphase/narrowphase.h"

namespace zoned::physics {

struct Thing {
    Shape shape;
    Vec3 position = Vec3::Zero();
    Mat3 rotation = Mat3::Identity();

    [[nodiscard]] Placed placed() const { return {shape, position, rotation}; }
};

inline Manifold collide_things(const Thing& a, const Thing& b, float margin = 0.02F) {
    Manifold m;
    collide(a.placed(), b.placed(), margin, m);
    return m;
}

}  // namespace zoned::physics
