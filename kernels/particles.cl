// Particles: one step of each particle of a system, in place. Options: ZK_AIR (ZK_AIR_NONE,
// ZK_AIR_STEADY or ZK_AIR_GUSTS), ZK_COLLIDE (0 or 1), ZK_TABLES_IN_GLOBAL_MEMORY.
#include "kernels/include/particle.h"

/// `columns` holds x, y, z, vx, vy, vz, one after the other, `stride` numbers apart, with room for
/// whole work groups. Items beyond the particles are worked on like them: a test of each item keeps
/// compilers from making vectors of the items (three times slower with PoCL). done[group] becomes
/// `stamp` when all of a group has been stored. Where a device gives up halfway, the host sees the
/// groups left to do.
__kernel void particles_step(__global float* columns,
                             const uint stride,
                             ZK_TABLE const ParticleWorld* world,
                             ZK_TABLE const float* gusts,
                             __global const float* heights,
                             __global uint* done,
                             const uint stamp) {
    __global float* x = columns + get_global_id(0);
    ParticleMotion m;
    m.x = x[0];
    m.y = x[stride];
    m.z = x[2 * stride];
    m.vx = x[3 * stride];
    m.vy = x[4 * stride];
    m.vz = x[5 * stride];
    const float from_x = m.x;
    const float from_y = m.y;
    const float from_z = m.z;
    particle_fly(&m, world, gusts, ZK_AIR);
#if ZK_COLLIDE
    particle_collide(&m, world, heights, from_x, from_y, from_z);
#endif
    x[0] = m.x;
    x[stride] = m.y;
    x[2 * stride] = m.z;
    x[3 * stride] = m.vx;
    x[4 * stride] = m.vy;
    x[5 * stride] = m.vz;
    barrier(CLK_GLOBAL_MEM_FENCE);
    if (get_local_id(0) == 0) {
        done[get_group_id(0)] = stamp;
    }
}
