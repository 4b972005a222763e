// OpenAPI: describes the routes of the admin server for programs (JSON) and for people (a page),
// from the routes themselves.
#pragma once

#include "server/admin/admin_router.h"

#include <string>
#include <vector>

namespace zoned::admin {

/// OpenAPI 3.0.3: every route with its parameters, bodies and answers; schemas come from the
/// messages of proto/admin.proto.
[[nodiscard]] std::string openapi_json(const std::vector<AdminRoute>& routes);

/// The same as a page of HTML without scripts.
[[nodiscard]] std::string openapi_page(const std::vector<AdminRoute>& routes);

/// The routes, and two more that describe all of them: /api/v1/openapi.json and /api.
[[nodiscard]] std::vector<AdminRoute> with_description(std::vector<AdminRoute> routes);

}  // namespace zoned::admin
