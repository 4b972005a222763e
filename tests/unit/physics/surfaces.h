// Surfaces: meshes and heightfields for the tests of the physics.
#pragma once

#include "server/physics/scene/scene.h"
#include "server/physics/shapes/heightfield.h"
#include "server/physics/shapes/mesh.h"

#include <functional>
#include <vector>

namespace zoned::physics {

struct MeshInput {
    std::vector<Vec3> vertices;
    std::vector<std::uint32_t> indices;

    void add(const Vec3& a, const Vec3& b, const Vec3& c) {
        for (const Vec3& p : {a, b, c}) {
            indices.push_back(static_cast<std::uint32_t>(vertices.size()));
            vertices.push_back(p);
        }
    }

    void add(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
        add(a, b, c);
        add(a, c, d);
    }
};

/// cells x cells squares around the origin, each split into two triangles in a chequered pattern.
/// Every triangle has vertices of its own.
inline MeshInput grid_mesh(int cells,
                           float cell,
                           const std::function<float(float x, float z)>& height) {
    MeshInput mesh;
    const float half = 0.5F * cell * static_cast<float>(cells);
    const auto at = [&](int i, int k) {
        const float x = static_cast<float>(i) * cell - half;
        const float z = static_cast<float>(k) * cell - half;
        return Vec3(x, height(x, z), z);
    };
    for (int i = 0; i < cells; ++i) {
        for (int k = 0; k < cells; ++k) {
            if ((i + k) % 2 == 0) {
                mesh.add(at(i, k), at(i, k + 1), at(i + 1, k + 1), at(i + 1, k));
            } else {
                mesh.add(at(i, k + 1), at(i + 1, k + 1), at(i + 1, k), at(i, k));
            }
        }
    }
    return mesh;
}

inline Shape mesh_shape(const MeshInput& input) {
    return Shape::mesh(build_mesh(input.vertices, input.indices)->mesh);
}

inline Shape field_shape(std::uint32_t samples,
                         float spacing,
                         const std::function<float(float x, float z)>& height) {
    std::vector<float> heights;
    const float half = 0.5F * spacing * static_cast<float>(samples - 1);
    for (std::uint32_t k = 0; k < samples; ++k) {
        for (std::uint32_t i = 0; i < samples; ++i) {
            heights.push_back(height(static_cast<float>(i) * spacing - half,
                                     static_cast<float>(k) * spacing - half));
        }
    }
    FieldOptions options;
    options.columns = samples;
    options.rows = samples;
    options.spacing_x = spacing;
    options.spacing_z = spacing;
    return Shape::heightfield(*build_heightfield(heights, options));
}

inline BodyId add_static(Scene& scene, const Shape& shape, const Material& material = {}) {
    BodyDef def;
    def.kind = BodyKind::kStatic;
    def.shape = shape;
    def.material = material;
    return *scene.add(def);
}

}  // namespace zoned::physics
