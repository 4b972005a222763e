// Flock: Reynolds' rules for agents in a grid of cells, for a batch of agents at once.
#pragma once

#include "kernels/include/kernel_base.h"

ZK_BEGIN

/// Columns of cells over the ground. A cell is as wide as an agent looks far, so every agent near
/// it is in the same cell or one beside it. An agent outside counts to the cells at the rim.
typedef struct FlockGrid {
    float x0, z0;       // m
    float cells_per_m;  // 1 / cell size
    int columns, rows;  // along x, along z
} FlockGrid;

typedef struct FlockRules {
    float h;                                            // s
    float radius2;                                      // m2, of neighbours
    float separation2;                                  // m2, within which they push off each other
    float separation;                                   // m2/s2: acceleration times distance
    float alignment;                                    // 1/s
    float cohesion;                                     // 1/s2
    float most_acceleration;                            // m/s2
    float least_speed;                                  // m/s
    float most_speed;                                   // m/s
    float low_x, low_y, low_z, high_x, high_y, high_z;  // where they are at home, m
    float turn_back;                                    // m/s2, outside of it
    // Where a table of directions steers (follow > 0): x and z of a vector no longer than 1 for
    // each cell, row by row. Beyond it the cells at the rim count.
    float follow;                   // 1/s: how fast velocities turn to most_speed along it
    float field_x0, field_z0;       // m
    float field_cells_per_m;        // 1 / cell size
    int field_columns, field_rows;  // along x, along z
} FlockRules;

/// Agents that are worked on together: neighbours in the sorted order, of one row of cells.
typedef struct FlockBatch {
    int begin, end;             // at most as many as lanes
    int first_cell, last_cell;  // columns in which they are
    int row;
} FlockBatch;

/// The cell 0..count - 1 of a place, in cells; NaN counts to the first.
ZK_FN int flock_clamp_cell(const float at, const int count) {
    const float high = (float)(count - 1);
    const float in = at > 0.0f ? (at < high ? at : high) : 0.0f;
    return (int)in;
}

ZK_FN int flock_cell(ZK_TABLE const FlockGrid* grid, const float x, const float z) {
    const int column = flock_clamp_cell((x - grid->x0) * grid->cells_per_m, grid->columns);
    const int row = flock_clamp_cell((z - grid->z0) * grid->cells_per_m, grid->rows);
    return row * grid->columns + column;
}

ZK_REAL_STRUCT struct FlockKernelSum {
    Real count;
    Real px, py, pz;  // offsets
    Real vx, vy, vz;
    Real sx, sy, sz;  // pushes
};
#ifdef __OPENCL_C_VERSION__
typedef struct FlockKernelSum FlockKernelSum;
#endif

/// Adds the neighbour at n: in the sum order of the sorted agents, so that it does not matter how
/// many agents are worked on together. Itself, at distance zero, does not count.
ZK_REAL_FN void flock_add(ZK_OF_REAL(FlockKernelSum) * s,
                          ZK_TABLE const FlockRules* rules,
                          const Real x,
                          const Real y,
                          const Real z,
                          const float nx,
                          const float ny,
                          const float nz,
                          const float nvx,
                          const float nvy,
                          const float nvz) {
    const Real zero = zk_splat(0.0f);
    const Real dx = nx - x;
    const Real dy = ny - y;
    const Real dz = nz - z;
    const Real d2 = dx * dx + dy * dy + dz * dz;
    const ZK_MASK near = (d2 < rules->radius2) & (d2 > 0.0f);
    const ZK_MASK close = (d2 < rules->separation2) & (d2 > 0.0f);
    s->count = s->count + zk_pick(near, zk_splat(1.0f), zero);
    s->px = s->px + zk_pick(near, dx, zero);
    s->py = s->py + zk_pick(near, dy, zero);
    s->pz = s->pz + zk_pick(near, dz, zero);
    s->vx = s->vx + zk_pick(near, zk_splat(nvx), zero);
    s->vy = s->vy + zk_pick(near, zk_splat(nvy), zero);
    s->vz = s->vz + zk_pick(near, zk_splat(nvz), zero);
    const Real push = zk_pick(close, 1.0f / d2, zero);
    s->sx = s->sx - push * dx;
    s->sy = s->sy - push * dy;
    s->sz = s->sz - push * dz;
}

/// The range of sorted agents that holds the neighbours of a batch in one row of cells. Beyond the
/// grid's first and last row there are none: begin and end are both where such agents would stand,
/// so that neither decreases from one batch to the next.
ZK_FN int flock_stretch_begin(ZK_TABLE const FlockGrid* grid,
                              ZK_GLOBAL const int* cell_begin,
                              const FlockBatch batch,
                              const int row) {
    const int first = batch.first_cell > 0 ? batch.first_cell - 1 : 0;
    const int in = row < grid->rows ? row * grid->columns + first : grid->rows * grid->columns;
    return row < 0 ? 0 : cell_begin[in];
}

ZK_FN int flock_stretch_end(ZK_TABLE const FlockGrid* grid,
                            ZK_GLOBAL const int* cell_begin,
                            const FlockBatch batch,
                            const int row) {
    const int last = batch.last_cell + 1 < grid->columns ? batch.last_cell + 1 : batch.last_cell;
    const int in = row < grid->rows ? row * grid->columns + last + 1 : grid->rows * grid->columns;
    return row < 0 ? 0 : cell_begin[in];
}

/// All neighbours of a batch: rows of cells around it, each one stretch of the sorted agents.
/// `sorted` holds x, y, z, vx, vy, vz, `stride` apart.
ZK_REAL_FN void flock_look(ZK_OF_REAL(FlockKernelSum) * s,
                           ZK_TABLE const FlockRules* rules,
                           ZK_TABLE const FlockGrid* grid,
                           const FlockBatch batch,
                           ZK_GLOBAL const int* cell_begin,
                           ZK_GLOBAL const float* sorted,
                           const int stride,
                           const Real x,
                           const Real y,
                           const Real z) {
    for (int row = batch.row - 1; row <= batch.row + 1; ++row) {
        const int end = flock_stretch_end(grid, cell_begin, batch, row);
        for (int j = flock_stretch_begin(grid, cell_begin, batch, row); j < end; ++j) {
            ZK_GLOBAL const float* n = sorted + j;
            flock_add(s,
                      rules,
                      x,
                      y,
                      z,
                      n[0],
                      n[stride],
                      n[2 * stride],
                      n[3 * stride],
                      n[4 * stride],
                      n[5 * stride]);
        }
    }
}

/// How much an axis is pushed back towards home.
ZK_REAL_FN Real flock_home(const Real x, const float low, const float high, const float push) {
    const Real zero = zk_splat(0.0f);
    return zk_pick(x < low, zk_splat(push), zk_pick(x > high, zk_splat(-push), zero));
}

/// Adds the acceleration that the table of directions asks for.
ZK_REAL_FN void flock_follow(ZK_TABLE const FlockRules* r,
                             ZK_GLOBAL const float* field,
                             const Real x,
                             const Real z,
                             const Real vx,
                             const Real vz,
                             Real* ax,
                             Real* az) {
    const Real zero = zk_splat(0.0f);
    const Real column = zk_clamp(
        (x - r->field_x0) * r->field_cells_per_m, zero, zk_splat((float)(r->field_columns - 1)));
    const Real row = zk_clamp(
        (z - r->field_z0) * r->field_cells_per_m, zero, zk_splat((float)(r->field_rows - 1)));
    const ZK_INT at = (zk_to_int(row) * r->field_columns + zk_to_int(column)) * 2;
    *ax = *ax + (zk_gather(field, at) * r->most_speed - vx) * r->follow;
    *az = *az + (zk_gather(field, at + 1) * r->most_speed - vz) * r->follow;
}

/// The rules (Reynolds, "Flocks, herds, and schools", SIGGRAPH 1987): away from agents that are too
/// near, with the mean velocity, to the middle, along the field. Then one step of semi-implicit
/// Euler with limits.
ZK_REAL_FN void flock_steer(const ZK_OF_REAL(FlockKernelSum) * s,
                            ZK_TABLE const FlockRules* r,
                            ZK_GLOBAL const float* field,
                            Real* x,
                            Real* y,
                            Real* z,
                            Real* vx,
                            Real* vy,
                            Real* vz) {
    const Real zero = zk_splat(0.0f);
    const ZK_MASK any = s->count > 0.0f;
    const Real share = zk_pick(any, 1.0f / s->count, zero);
    const Real follow = zk_pick(any, zk_splat(r->alignment), zero);
    Real ax = s->px * share * r->cohesion + (s->vx * share - *vx) * follow + s->sx * r->separation;
    Real ay = s->py * share * r->cohesion + (s->vy * share - *vy) * follow + s->sy * r->separation;
    Real az = s->pz * share * r->cohesion + (s->vz * share - *vz) * follow + s->sz * r->separation;
    if (r->follow > 0.0f) {
        flock_follow(r, field, *x, *z, *vx, *vz, &ax, &az);
    }
    const Real a2 = ax * ax + ay * ay + az * az;
    const float most2 = r->most_acceleration * r->most_acceleration;
    const Real cut = zk_pick(a2 > most2, r->most_acceleration / zk_sqrt(a2), zk_splat(1.0f));
    const Real hx = flock_home(*x, r->low_x, r->high_x, r->turn_back);
    const Real hy = flock_home(*y, r->low_y, r->high_y, r->turn_back);
    const Real hz = flock_home(*z, r->low_z, r->high_z, r->turn_back);
    ax = ax * cut + hx;
    ay = ay * cut + hy;
    az = az * cut + hz;
    const Real nx = *vx + r->h * ax;
    const Real ny = *vy + r->h * ay;
    const Real nz = *vz + r->h * az;
    const Real speed = zk_sqrt(nx * nx + ny * ny + nz * nz);
    // Outside, nothing keeps up the speed: one that flies straight out could never turn.
    const ZK_MASK outside = hx * hx + hy * hy + hz * hz > 0.0f;
    const Real least = zk_pick(outside, zero, zk_splat(r->least_speed));
    const Real wanted = zk_clamp(speed, least, zk_splat(r->most_speed));
    const Real scale = zk_pick(speed > 0.0f, wanted / speed, zero);
    *vx = nx * scale;
    *vy = ny * scale;
    *vz = nz * scale;
    *x = *x + r->h * *vx;
    *y = *y + r->h * *vy;
    *z = *z + r->h * *vz;
}

ZK_END
