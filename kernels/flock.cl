// Flock: one step of a batch of up to eight agents per work item.
#define ZK_WIDE
#include "kernels/include/flock.h"

/// `sorted` is the state before the step in the order of cells and stays as it is; agent order[i]
/// of `agents` gets what sorted agent i becomes. Both hold x, y, z, vx, vy, vz, `stride` apart.
__kernel void flock_step(__global float* agents,
                         __global const float* sorted,
                         const int stride,
                         __global const int* order,
                         __global const int* cell_begin,
                         __global const FlockBatch* batches,
                         const int batch_count,
                         ZK_TABLE const FlockRules* rules,
                         ZK_TABLE const FlockGrid* grid) {
    const int b = get_global_id(0);
    if (b >= batch_count) {
        return;
    }
    const FlockBatch batch = batches[b];
    __global const float* at = sorted + batch.begin;
    Real x = vload8(0, at);
    Real y = vload8(0, at + stride);
    Real z = vload8(0, at + 2 * stride);
    Real vx = vload8(0, at + 3 * stride);
    Real vy = vload8(0, at + 4 * stride);
    Real vz = vload8(0, at + 5 * stride);
    FlockSum sum = {0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f};
    flock_look(&sum, rules, grid, batch, cell_begin, sorted, stride, x, y, z);
    flock_steer(&sum, rules, &x, &y, &z, &vx, &vy, &vz);
    float out[6][8];
    vstore8(x, 0, out[0]);
    vstore8(y, 0, out[1]);
    vstore8(z, 0, out[2]);
    vstore8(vx, 0, out[3]);
    vstore8(vy, 0, out[4]);
    vstore8(vz, 0, out[5]);
    for (int i = batch.begin; i < batch.end; ++i) {
        __global float* to = agents + order[i];
        for (int c = 0; c < 6; ++c) {
            to[c * stride] = out[c][i - batch.begin];
        }
    }
}
