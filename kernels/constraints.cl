// Constraints: the links of one colour, which share no node, so that all may be solved at once.
// Reached by no program yet: soft bodies on a device will use it.
#include "kernels/include/constraint.h"

/// `nodes` holds x, y, z and inverse mass, `stride` apart; links and lambdas [first, first + count)
/// are of one colour. `per_h2` is 1 / h^2, 1/s2.
__kernel void constraints_solve(__global float* nodes,
                                const int stride,
                                __global const DistanceLink* links,
                                __global float* lambdas,
                                const int first,
                                const int count,
                                const float per_h2) {
    const int i = get_global_id(0);
    if (i >= count) {
        return;
    }
    const DistanceLink link = links[first + i];
    __global float* a = nodes + link.a;
    __global float* b = nodes + link.b;
    float ax = a[0];
    float ay = a[stride];
    float az = a[2 * stride];
    float bx = b[0];
    float by = b[stride];
    float bz = b[2 * stride];
    float lambda = lambdas[first + i];
    constraint_solve(&ax, &ay, &az, a[3 * stride], &bx, &by, &bz, b[3 * stride], link.rest,
                     link.compliance * per_h2, &lambda);
    lambdas[first + i] = lambda;
    a[0] = ax;
    a[stride] = ay;
    a[2 * stride] = az;
    b[0] = bx;
    b[stride] = by;
    b[2 * stride] = bz;
}
