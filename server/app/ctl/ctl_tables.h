// Ctl tables: the answers of the admin interface as text for a terminal.
#pragma once

#include "proto/admin.pb.h"

#include <string>

namespace zoned::app {

[[nodiscard]] std::string status_text(const proto::admin::Status& status);
/// The passes that took most of the time, at most `most`.
[[nodiscard]] std::string passes_text(const proto::admin::Status& status, int most);
[[nodiscard]] std::string sessions_text(const proto::admin::SessionList& list);
[[nodiscard]] std::string zones_text(const proto::admin::ZoneList& list);
[[nodiscard]] std::string bans_text(const proto::admin::BanList& list);
[[nodiscard]] std::string entity_text(const proto::admin::EntityFigures& entity);

}  // namespace zoned::app
