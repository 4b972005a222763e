// Flock: one step of a batch of up to eight agents per work item; their neighbours are read from
// where they lie, or from tiles in local memory.
#define ZK_WIDE
#include "kernels/include/flock.h"

typedef struct FlockEight {
    Real x, y, z, vx, vy, vz;
} FlockEight;

/// `sorted` holds x, y, z, vx, vy, vz, `stride` apart; lanes beyond the batch hold the agents that
/// follow.
static inline FlockEight flock_load(__global const float* sorted,
                                    const int stride,
                                    const FlockBatch batch) {
    __global const float* at = sorted + batch.begin;
    FlockEight a;
    a.x = vload8(0, at);
    a.y = vload8(0, at + stride);
    a.z = vload8(0, at + 2 * stride);
    a.vx = vload8(0, at + 3 * stride);
    a.vy = vload8(0, at + 4 * stride);
    a.vz = vload8(0, at + 5 * stride);
    return a;
}

/// Stores the batch after its step at the places that `order` names.
static inline void flock_end(const FlockKernelSum* sum,
                             ZK_TABLE const FlockRules* rules,
                             __global const float* field,
                             FlockEight a,
                             const FlockBatch batch,
                             __global const int* order,
                             __global float* agents,
                             const int stride) {
    flock_steer(sum, rules, field, &a.x, &a.y, &a.z, &a.vx, &a.vy, &a.vz);
    float out[6][8];
    vstore8(a.x, 0, out[0]);
    vstore8(a.y, 0, out[1]);
    vstore8(a.z, 0, out[2]);
    vstore8(a.vx, 0, out[3]);
    vstore8(a.vy, 0, out[4]);
    vstore8(a.vz, 0, out[5]);
    for (int i = batch.begin; i < batch.end; ++i) {
        __global float* to = agents + order[i];
        for (int c = 0; c < 6; ++c) {
            to[c * stride] = out[c][i - batch.begin];
        }
    }
}

/// `sorted` is the state before the step in the order of cells and stays as it is. Agent order[i]
/// of `agents` gets the new state of sorted agent i. Both hold x, y, z, vx, vy, vz, `stride` apart.
__kernel void flock_step(__global float* agents,
                         __global const float* sorted,
                         const int stride,
                         __global const int* order,
                         __global const int* cell_begin,
                         __global const FlockBatch* batches,
                         const int batch_count,
                         ZK_TABLE const FlockRules* rules,
                         ZK_TABLE const FlockGrid* grid,
                         __global const float* field) {
    const int b = get_global_id(0);
    if (b >= batch_count) {
        return;
    }
    const FlockBatch batch = batches[b];
    const FlockEight a = flock_load(sorted, stride, batch);
    FlockKernelSum sum = {0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f};
    flock_look(&sum, rules, grid, batch, cell_begin, sorted, stride, a.x, a.y, a.z);
    flock_end(&sum, rules, field, a, batch, order, agents, stride);
}

/// The same. Batches of a work group are neighbours in the sorted order, so their stretches of a
/// row of cells are one stretch together. The group copies it to local memory tile by tile, and
/// each batch adds its own part of a tile. A tile (`tile_agents` of each column, all six) may hold
/// a part of a cell or many cells: the sum order is that of flock_step whatever its size. (Tiles of
/// the all-pairs problem: Nyland, Harris and Prins, "Fast N-body simulation with CUDA", GPU Gems 3,
/// 2007, section 31.3.)
__kernel void flock_step_tiles(__global float* agents,
                               __global const float* sorted,
                               const int stride,
                               __global const int* order,
                               __global const int* cell_begin,
                               __global const FlockBatch* batches,
                               const int batch_count,
                               ZK_TABLE const FlockRules* rules,
                               ZK_TABLE const FlockGrid* grid,
                               __global const float* field,
                               __local float* tile,
                               const int tile_agents) {
    const int items = get_local_size(0);
    const int first = get_group_id(0) * items;
    const int last = min(first + items, batch_count) - 1;
    // Items beyond the last batch load tiles and meet the others at barriers.
    const int b = first + (int)get_local_id(0);
    const FlockBatch batch = batches[min(b, last)];
    const FlockBatch first_batch = batches[first];
    const FlockBatch last_batch = batches[last];
    const FlockEight a = flock_load(sorted, stride, batch);
    FlockKernelSum sum = {0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f};
    for (int r = -1; r <= 1; ++r) {
        const int low = flock_stretch_begin(grid, cell_begin, first_batch, first_batch.row + r);
        const int high = flock_stretch_end(grid, cell_begin, last_batch, last_batch.row + r);
        const int begin = flock_stretch_begin(grid, cell_begin, batch, batch.row + r);
        const int end = flock_stretch_end(grid, cell_begin, batch, batch.row + r);
        for (int t = low; t < high; t += tile_agents) {
            const int n = min(tile_agents, high - t);
            barrier(CLK_LOCAL_MEM_FENCE);  // all are done with the tile before
            for (int i = get_local_id(0); i < n; i += items) {
                for (int c = 0; c < 6; ++c) {
                    tile[c * tile_agents + i] = sorted[c * stride + t + i];
                }
            }
            barrier(CLK_LOCAL_MEM_FENCE);
            const int stop = min(end, t + n) - t;
            for (int j = max(begin, t) - t; j < stop; ++j) {
                __local const float* n_at = tile + j;
                flock_add(&sum, rules, a.x, a.y, a.z, n_at[0], n_at[tile_agents],
                          n_at[2 * tile_agents], n_at[3 * tile_agents], n_at[4 * tile_agents],
                          n_at[5 * tile_agents]);
            }
        }
    }
    if (b <= last) {
        flock_end(&sum, rules, field, a, batch, order, agents, stride);
    }
}
