#include "shared/wire/field_table.h"

#include "shared/core/assert.h"

namespace zoned::wire {

Columns columns_of(const QuantizedState& s) {
    ZONED_ASSERT(!s.at_rest || s.order == motion::PredictorOrder::kStatic,
                 "an entity at rest is predicted with order 0");
    const int motion = s.at_rest ? 0 : 1 + static_cast<int>(s.order);
    return {motion,
            s.position[0],
            s.position[2],
            s.position[1],
            s.velocity[0],
            s.velocity[2],
            s.velocity[1],
            s.acceleration[0],
            s.acceleration[2],
            s.acceleration[1],
            s.orientation[0],
            s.orientation[1],
            s.orientation[2],
            s.orientation_largest,
            s.angular_velocity[0],
            s.angular_velocity[2],
            s.angular_velocity[1],
            s.appearance,
            s.turn[0],
            s.turn[2],
            s.turn[1],
            s.floor};
}

QuantizedState state_of(const Columns& c) {
    QuantizedState s;
    s.at_rest = c[0] == 0;
    s.order = static_cast<motion::PredictorOrder>(s.at_rest ? 0 : c[0] - 1);
    s.position = {c[1], c[3], c[2]};
    s.velocity = {c[4], c[6], c[5]};
    s.acceleration = {c[7], c[9], c[8]};
    s.orientation = {c[10], c[11], c[12]};
    s.orientation_largest = c[13];
    s.angular_velocity = {c[14], c[16], c[15]};
    s.appearance = static_cast<std::uint16_t>(c[17]);
    s.turn = {c[18], c[20], c[19]};
    s.floor = c[21];
    return s;
}

}  // namespace zoned::wire
