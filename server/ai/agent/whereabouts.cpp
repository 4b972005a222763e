#include "server/ai/agent/whereabouts.h"

namespace zoned::ai {

bool keeps_to_segment(const Agent& agent, const Vec2& body, Tick now, float dt) {
    return agent.timed && (agent.tier != Tier::kActive ||
                           !((position_at(agent.segment, now - 1, dt) - body).norm() > kDriftM));
}

Vec2 whereabouts(const Agent& agent, const Vec2& body, Tick now, float dt) {
    return keeps_to_segment(agent, body, now, dt) ? position_at(agent.segment, now - 1, dt) : body;
}

}  // namespace zoned::ai
