// Topics: publish-subscribe for what is not spatial (team, zone, world).
#pragma once

#include "shared/core/ids.h"

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace zoned::interest {

/// Names are "world", "zone/<id>", "team/<name>" or a studio's own, 1..64 bytes.
class Topics {
  public:
    void subscribe(ClientId client, std::string_view topic);
    void unsubscribe(ClientId client, std::string_view topic);
    void remove(ClientId client);  ///< from all topics
    /// Subscribers ascending by client id; empty for an unknown topic.
    [[nodiscard]] const std::vector<ClientId>& subscribers(std::string_view topic) const;

  private:
    std::map<std::string, std::vector<ClientId>, std::less<>> subscribers_;
};

}  // namespace zoned::interest
