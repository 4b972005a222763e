// Particles: the flight and the bounces of a particle in one step of semi-implicit Euler.
#pragma once

#include "kernels/include/kernel_base.h"

ZK_BEGIN

enum {
    ZK_MOST_PLANES = 8,
    ZK_MOST_SPHERES = 16,
    /// Gusts are given at the corners of a lattice with so many cells along each axis. The lattice
    /// repeats.
    ZK_GUST_CELLS = 8,
    ZK_GUST_CORNERS = ZK_GUST_CELLS * ZK_GUST_CELLS * ZK_GUST_CELLS
};

/// Solid where n . p < offset; n has unit length.
typedef struct ParticlePlane {
    float nx, ny, nz;
    float offset;  // m
} ParticlePlane;

typedef struct ParticleSphere {
    float x, y, z;
    float radius;  // m, > 0
} ParticleSphere;

/// Heights over a grid, as physics::Heightfield lays it out: sample (i, k) lies at
/// x = x0 + i spacing_x, z = z0 + k spacing_z; the diagonal of a cell runs from its lowest x and z
/// to its highest. Solid from `bottom` up to the surface.
typedef struct ParticleField {
    int columns;  // 0: there is none
    int rows;
    float x0, y0, z0;
    float spacing_x, spacing_z;  // m
    float bottom;                // m
} ParticleField;

/// Everything that acts on all particles of a system during one step. SI units; y is up.
typedef struct ParticleWorld {
    float h;                       // s
    float gx, gy, gz;              // m/s2
    float linear_drag;             // 1/s, >= 0
    float quadratic_drag;          // 1/m, >= 0
    float wind_x, wind_y, wind_z;  // m/s
    float gust_x, gust_y, gust_z;  // where the lattice of the gusts begins, m
    float gust_cells_per_m;
    float restitution;  // 0..1
    float friction;     // >= 0
    float radius;       // of a particle when it collides, m
    int planes;
    int spheres;
    ParticleField field;
    ParticlePlane plane[ZK_MOST_PLANES];
    ParticleSphere sphere[ZK_MOST_SPHERES];
} ParticleWorld;

/// Air: the parts for which a program or template is made, so that no particle pays for a missing
/// part.
enum {
    ZK_AIR_NONE = 0,    // vacuum
    ZK_AIR_STEADY = 1,  // drag in a uniform wind
    ZK_AIR_GUSTS = 2    // and gusts
};

ZK_REAL_STRUCT struct ParticleMotion {
    Real x, y, z;
    Real vx, vy, vz;
};
#ifdef __OPENCL_C_VERSION__
typedef struct ParticleMotion ParticleMotion;
#endif

/// Smooth weight between lattice corners: 3 t^2 - 2 t^3, whose slope is zero at both ends, so that
/// the gusts have no creases (Perlin, "An image synthesizer", SIGGRAPH 1985).
ZK_REAL_FN Real particle_ease(const Real t) {
    return t * t * (3.0f - 2.0f * t);
}

/// One component of the gusts around a corner: eight corners, mixed along x, then y, then z.
ZK_REAL_FN Real particle_mix(ZK_TABLE const float* table,
                             const ZK_INT x0,
                             const ZK_INT x1,
                             const ZK_INT y0,
                             const ZK_INT y1,
                             const ZK_INT z0,
                             const ZK_INT z1,
                             const Real u,
                             const Real v,
                             const Real w) {
    const Real a0 = zk_gather(table, x0 + y0 + z0);
    const Real a1 = zk_gather(table, x1 + y0 + z0);
    const Real b0 = zk_gather(table, x0 + y1 + z0);
    const Real b1 = zk_gather(table, x1 + y1 + z0);
    const Real c0 = zk_gather(table, x0 + y0 + z1);
    const Real c1 = zk_gather(table, x1 + y0 + z1);
    const Real d0 = zk_gather(table, x0 + y1 + z1);
    const Real d1 = zk_gather(table, x1 + y1 + z1);
    const Real a = a0 + u * (a1 - a0);
    const Real b = b0 + u * (b1 - b0);
    const Real c = c0 + u * (c1 - c0);
    const Real d = d0 + u * (d1 - d0);
    const Real e = a + v * (b - a);
    const Real f = c + v * (d - c);
    return e + w * (f - e);
}

/// Adds the gust at a place to a wind. `gusts` holds ZK_GUST_CORNERS numbers for each component,
/// x running fastest.
ZK_REAL_FN void particle_gust(ZK_TABLE const ParticleWorld* world,
                              ZK_TABLE const float* gusts,
                              const Real x,
                              const Real y,
                              const Real z,
                              Real* wx,
                              Real* wy,
                              Real* wz) {
    const Real px = (x - world->gust_x) * world->gust_cells_per_m;
    const Real py = (y - world->gust_y) * world->gust_cells_per_m;
    const Real pz = (z - world->gust_z) * world->gust_cells_per_m;
    const Real fx = zk_floor(px);
    const Real fy = zk_floor(py);
    const Real fz = zk_floor(pz);
    const ZK_INT ix = zk_to_int(fx);
    const ZK_INT iy = zk_to_int(fy);
    const ZK_INT iz = zk_to_int(fz);
    const ZK_INT x0 = ix & (ZK_GUST_CELLS - 1);
    const ZK_INT x1 = (ix + 1) & (ZK_GUST_CELLS - 1);
    const ZK_INT y0 = (iy & (ZK_GUST_CELLS - 1)) * (int)ZK_GUST_CELLS;
    const ZK_INT y1 = ((iy + 1) & (ZK_GUST_CELLS - 1)) * (int)ZK_GUST_CELLS;
    const ZK_INT z0 = (iz & (ZK_GUST_CELLS - 1)) * (int)(ZK_GUST_CELLS * ZK_GUST_CELLS);
    const ZK_INT z1 = ((iz + 1) & (ZK_GUST_CELLS - 1)) * (int)(ZK_GUST_CELLS * ZK_GUST_CELLS);
    const Real u = particle_ease(px - fx);
    const Real v = particle_ease(py - fy);
    const Real w = particle_ease(pz - fz);
    *wx = *wx + particle_mix(gusts, x0, x1, y0, y1, z0, z1, u, v, w);
    *wy = *wy + particle_mix(gusts + ZK_GUST_CORNERS, x0, x1, y0, y1, z0, z1, u, v, w);
    *wz = *wz + particle_mix(gusts + 2 * ZK_GUST_CORNERS, x0, x1, y0, y1, z0, z1, u, v, w);
}

/// Semi-implicit Euler: the velocity first, then the position with the new velocity. Drag is
/// linearly implicit in the velocity relative to the air, w. After the forces the share 1 / (1 + h
/// (k1 + k2 |w|)) of it is left, with |w| taken before them. The scheme is of first order and
/// stable for any drag and any step. Its terminal speed, at which drag carries the weight, is
/// exact.
ZK_REAL_FN void particle_fly(ZK_OF_REAL(ParticleMotion) * m,
                             ZK_TABLE const ParticleWorld* world,
                             ZK_TABLE const float* gusts,
                             const int air) {
    const float h = world->h;
    const Real kx = m->vx + h * world->gx;
    const Real ky = m->vy + h * world->gy;
    const Real kz = m->vz + h * world->gz;
    if (air == ZK_AIR_NONE) {
        m->vx = kx;
        m->vy = ky;
        m->vz = kz;
    } else {
        Real wx = zk_splat(world->wind_x);
        Real wy = zk_splat(world->wind_y);
        Real wz = zk_splat(world->wind_z);
        if (air == ZK_AIR_GUSTS) {
            particle_gust(world, gusts, m->x, m->y, m->z, &wx, &wy, &wz);
        }
        const Real rx = m->vx - wx;
        const Real ry = m->vy - wy;
        const Real rz = m->vz - wz;
        const Real speed = zk_sqrt(rx * rx + ry * ry + rz * rz);
        const Real left = 1.0f / (1.0f + h * (world->linear_drag + world->quadratic_drag * speed));
        m->vx = wx + (kx - wx) * left;
        m->vy = wy + (ky - wy) * left;
        m->vz = wz + (kz - wz) * left;
    }
    m->x = m->x + h * m->vx;
    m->y = m->y + h * m->vy;
    m->z = m->z + h * m->vz;
}

/// Where `hit`, moves the particle by `depth` along the unit normal and, where it comes in, turns
/// its velocity: the normal part with restitution, the tangential part slowed by at most friction
/// times the normal impulse (Coulomb).
ZK_REAL_FN void particle_bounce(ZK_OF_REAL(ParticleMotion) * m,
                                ZK_TABLE const ParticleWorld* world,
                                const ZK_MASK hit,
                                const Real nx,
                                const Real ny,
                                const Real nz,
                                const Real depth) {
    const Real push = zk_pick(hit, depth, zk_splat(0.0f));
    m->x = m->x + push * nx;
    m->y = m->y + push * ny;
    m->z = m->z + push * nz;
    const Real in = m->vx * nx + m->vy * ny + m->vz * nz;
    const Real tx = m->vx - in * nx;
    const Real ty = m->vy - in * ny;
    const Real tz = m->vz - in * nz;
    const Real slide = zk_sqrt(tx * tx + ty * ty + tz * tz);
    const Real lost = world->friction * (1.0f + world->restitution) * -in;
    const Real keep = zk_pick(slide > lost, (slide - lost) / slide, zk_splat(0.0f));
    const Real out = -world->restitution * in;
    const ZK_MASK turns = hit & (in < 0.0f);
    m->vx = zk_pick(turns, tx * keep + out * nx, m->vx);
    m->vy = zk_pick(turns, ty * keep + out * ny, m->vy);
    m->vz = zk_pick(turns, tz * keep + out * nz, m->vz);
}

/// A particle enters the sphere where the line from `from` to it first meets the sphere, so no
/// speed lets it pass through. A particle that is inside already (the sphere moved) is pushed out.
ZK_REAL_FN void particle_hit_sphere(ZK_OF_REAL(ParticleMotion) * m,
                                    ZK_TABLE const ParticleWorld* world,
                                    ZK_TABLE const ParticleSphere* sphere,
                                    const Real from_x,
                                    const Real from_y,
                                    const Real from_z) {
    const float r = sphere->radius + world->radius;
    const Real ox = from_x - sphere->x;
    const Real oy = from_y - sphere->y;
    const Real oz = from_z - sphere->z;
    const Real dx = m->x - from_x;
    const Real dy = m->y - from_y;
    const Real dz = m->z - from_z;
    const Real a = dx * dx + dy * dy + dz * dz;
    const Real b = ox * dx + oy * dy + oz * dz;
    const Real c = ox * ox + oy * oy + oz * oz - r * r;
    const Real q = b * b - a * c;
    const Real root = zk_sqrt(zk_pick(q > 0.0f, q, zk_splat(0.0f)));
    const Real t = (-b - root) / a;
    const ZK_MASK enters = (c >= 0.0f) & (q > 0.0f) & (b < 0.0f) & (t <= 1.0f);
    // Where it enters, or where it is now, relative to the centre.
    const Real px = zk_pick(enters, ox + t * dx, ox + dx);
    const Real py = zk_pick(enters, oy + t * dy, oy + dy);
    const Real pz = zk_pick(enters, oz + t * dz, oz + dz);
    const Real d2 = px * px + py * py + pz * pz;
    const ZK_MASK inside = (d2 < r * r) & (d2 > 0.0f);
    const ZK_MASK hit = enters | inside;
    const Real d = zk_sqrt(zk_pick(hit, d2, zk_splat(1.0f)));
    m->x = zk_pick(enters, sphere->x + px, m->x);
    m->y = zk_pick(enters, sphere->y + py, m->y);
    m->z = zk_pick(enters, sphere->z + pz, m->z);
    particle_bounce(m, world, hit, px / d, py / d, pz / d, r - d);
}

/// Out of the triangle of the field over or under the particle, along its normal.
ZK_REAL_FN void particle_hit_field(ZK_OF_REAL(ParticleMotion) * m,
                                   ZK_TABLE const ParticleWorld* world,
                                   ZK_GLOBAL const float* heights) {
    ZK_TABLE const ParticleField* field = &world->field;
    const Real gx = (m->x - field->x0) / field->spacing_x;
    const Real gz = (m->z - field->z0) / field->spacing_z;
    const ZK_MASK over = (gx >= 0.0f) & (gx <= zk_splat((float)(field->columns - 1))) &
                         (gz >= 0.0f) & (gz <= zk_splat((float)(field->rows - 1)));
    const Real zero = zk_splat(0.0f);
    const Real cx = zk_floor(zk_clamp(gx, zero, zk_splat((float)(field->columns - 2))));
    const Real cz = zk_floor(zk_clamp(gz, zero, zk_splat((float)(field->rows - 2))));
    const ZK_INT at = zk_to_int(cz) * field->columns + zk_to_int(cx);
    const Real fx = gx - cx;
    const Real fz = gz - cz;
    const Real h00 = zk_gather(heights, at);
    const Real h11 = zk_gather(heights, at + field->columns + 1);
    // The third corner: (1, 0) on the half towards +x, (0, 1) on the other.
    const ZK_MASK right = fx >= fz;
    const Real apex = zk_gather(heights, zk_pick(right, at + 1, at + field->columns));
    const Real sx = zk_pick(right, apex - h00, h11 - apex) / field->spacing_x;
    const Real sz = zk_pick(right, h11 - apex, apex - h00) / field->spacing_z;
    const Real length = zk_sqrt(sx * sx + sz * sz + 1.0f);
    const Real surface =
        h00 + field->y0 + sx * (fx * field->spacing_x) + sz * (fz * field->spacing_z);
    const Real depth = world->radius - (m->y - surface) / length;
    const ZK_MASK hit = over & (depth > 0.0f) & (m->y >= field->bottom);
    const Real up = 1.0f / length;
    particle_bounce(m, world, hit, -sx * up, up, -sz * up, depth);
}

/// Spheres, then planes, then the field: a particle pushed by one may be pushed by the next.
ZK_REAL_FN void particle_collide(ZK_OF_REAL(ParticleMotion) * m,
                                 ZK_TABLE const ParticleWorld* world,
                                 ZK_GLOBAL const float* heights,
                                 const Real from_x,
                                 const Real from_y,
                                 const Real from_z) {
    for (int i = 0; i < world->spheres; ++i) {
        particle_hit_sphere(m, world, &world->sphere[i], from_x, from_y, from_z);
    }
    for (int i = 0; i < world->planes; ++i) {
        const Real nx = zk_splat(world->plane[i].nx);
        const Real ny = zk_splat(world->plane[i].ny);
        const Real nz = zk_splat(world->plane[i].nz);
        const Real depth =
            world->radius + world->plane[i].offset - (nx * m->x + ny * m->y + nz * m->z);
        particle_bounce(m, world, depth > 0.0f, nx, ny, nz, depth);
    }
    if (world->field.columns > 0) {
        particle_hit_field(m, world, heights);
    }
}

ZK_END
