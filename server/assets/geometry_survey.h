// Geometry survey: the figures of a surface, and its parts that are too small, too thin or too far
// out for the physics.
#pragma once

#include "server/physics/shapes/heightfield.h"
#include "server/physics/shapes/mesh.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace zoned::assets {

/// How many triangles have something in common, and the one that has it most.
struct Worst {
    std::uint32_t count = 0;
    float least = INFINITY;  ///< m
    Vec3 at = Vec3::Zero();  ///< middle of that triangle, m
};

struct MeshSurvey {
    std::uint32_t triangles = 0;
    std::uint32_t vertices = 0;
    Aabb box;                        ///< m
    float shortest_edge = INFINITY;  ///< m
    float longest_edge = 0.0F;
    float farthest = 0.0F;  ///< largest coordinate, m
    Worst small;            ///< longest edge below the error budget
    Worst thin;             ///< no small ones; least height below the error budget
    Worst sheet;            ///< the back of another triangle lies behind within the contact margin
    std::uint32_t looked = 0;  ///< triangles looked behind: a sample where all take too long
    std::size_t depth = 0;     ///< of the tree, levels
    std::size_t nodes = 0;
    std::size_t bytes = 0;  ///< of memory
};

MeshSurvey survey(const physics::TriangleMesh& mesh, float error_budget_m);

struct FieldSurvey {
    std::uint32_t columns = 0;
    std::uint32_t rows = 0;
    Aabb box;  ///< m, without the thickness
    float spacing_x = 0.0F;
    float spacing_z = 0.0F;
    float thickness = 0.0F;
    float steepest_deg = 0.0F;
    std::uint32_t steepest_i = 0;  ///< cell where it is so steep: its sample with least x and z
    std::uint32_t steepest_k = 0;
    float farthest = 0.0F;
    std::size_t bytes = 0;
};

FieldSurvey survey(const physics::Heightfield& field);

/// Properties that the engine accepts but cannot simulate within the error budget, m. One sentence
/// each, with figures and the worst place; empty where there are none. See
/// physics::stability_warnings_of.
std::vector<std::string> stability_warnings_of(const MeshSurvey& mesh, float error_budget_m);

/// `level_m`: height of one step of the samples that the field was made from; 0: not known.
std::vector<std::string> stability_warnings_of(const FieldSurvey& field,
                                               float level_m,
                                               float error_budget_m);

}  // namespace zoned::assets
