// StopContext: what rules may do when their zone has run its last tick.
#pragma once

#include "server/zone/context/zone_context.h"

#include <string_view>

namespace zoned::zone {

/// They read the zone as that tick left it, write to the store and to the log. Nothing of it is
/// state: no client, recording or snapshot knows of it.
class StopContext {
  public:
    explicit StopContext(ZoneState& state) : context_(state), out_(&state.out) {}

    [[nodiscard]] const RulesContext& zone() const { return context_; }

    /// No answer comes. False: refused at once, as by RulesContext::store_put.
    bool store_put(const mailbox::StoreKey& key, Bytes value);
    bool store_remove(const mailbox::StoreKey& key);

    void log(std::string_view line) { context_.log(line); }

  private:
    bool ask(mailbox::StoreAct act, const mailbox::StoreKey& key, Bytes value);

    ZoneContext context_;
    StepOutput* out_;
};

}  // namespace zoned::zone
