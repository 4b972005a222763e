// Matching: the entities that each viewer hears of, one viewer per work item.
#include "kernels/include/match.h"

/// `entities` is sorted by cell: x at 0, z at 2 and the aura at 3 times `stride`. found[v] becomes how
/// many viewer v hears of; the first `most` of them, in sorted order, stand from out[v most] on.
/// `reach` is the largest aura.
__kernel void matching_viewers(__global const MatchViewer* viewers,
                               const int viewer_count,
                               __global const float* entities,
                               const int stride,
                               __global const int* order,
                               __global const int* cell_begin,
                               ZK_TABLE const FlockGrid* grid,
                               const float reach,
                               __global int* found,
                               __global int* out,
                               const int most) {
    const int v = get_global_id(0);
    if (v >= viewer_count) {
        return;
    }
    const MatchViewer viewer = viewers[v];
    const float r = viewer.nimbus < reach ? viewer.nimbus : reach;
    const float x = viewer.x - grid->x0;
    const float z = viewer.z - grid->z0;
    const int first = flock_clamp_cell((x - r) * grid->cells_per_m, grid->columns);
    const int last = flock_clamp_cell((x + r) * grid->cells_per_m, grid->columns);
    const int low = flock_clamp_cell((z - r) * grid->cells_per_m, grid->rows);
    const int high = flock_clamp_cell((z + r) * grid->cells_per_m, grid->rows);
    int count = 0;
    for (int row = low; row <= high && r > 0.0f; ++row) {
        const int end = cell_begin[row * grid->columns + last + 1];
        for (int j = cell_begin[row * grid->columns + first]; j < end; ++j) {
            if (match_hears(entities[j] - viewer.x,
                            entities[j + 2 * stride] - viewer.z,
                            entities[j + 3 * stride],
                            viewer.nimbus)) {
                if (count < most) {
                    out[(size_t)v * most + count] = order[j];
                }
                ++count;
            }
        }
    }
    found[v] = count;
}
