// The description of the admin interface: every route is in it, and nothing else.
#include "server/admin/openapi.h"

#include "tests/unit/json_reader.h"
#include "proto/admin.pb.h"

#include <gmock/gmock.h>

namespace zoned::admin {
namespace {

using json_text::field;
using json_text::field_names;
using ::testing::HasSubstr;
using ::testing::UnorderedElementsAre;

std::vector<AdminRoute> some_routes() {
    const auto nothing = [](const AdminCall&, const AdminReply&) {
    };
    return {{"GET",
             "/api/v1/sessions",
             false,
             nothing,
             {"Clients <all>",
              nullptr,
              proto::admin::SessionList::descriptor(),
              {{"after", "only greater numbers"}}}},
            {"GET", "/api/v1/entities/{id}", false, nothing, {"One entity", nullptr, nullptr}},
            {"POST",
             "/api/v1/kick",
             false,
             nothing,
             {"End sessions",
              proto::admin::KickRequest::descriptor(),
              proto::admin::Done::descriptor()}},
            {"GET", "/healthz", true, nothing, {"Alive", nullptr, nullptr, {}, "text/plain"}}};
}

TEST(OpenApi, DescribesEveryRouteAndItself) {
    const std::vector<AdminRoute> routes = with_description(some_routes());
    ASSERT_EQ(routes.size(), 6U);
    const auto document = json_text::parse(openapi_json(routes));
    const auto paths = field(document, "paths").struct_value();
    EXPECT_THAT(field_names(paths),
                UnorderedElementsAre("/api",
                                     "/api/v1/entities/{id}",
                                     "/api/v1/kick",
                                     "/api/v1/openapi.json",
                                     "/api/v1/sessions",
                                     "/healthz"));
    for (const AdminRoute& route : routes) {
        const auto path = field(paths, route.path).struct_value();
        EXPECT_THAT(field_names(path),
                    UnorderedElementsAre(route.method == "GET" ? "get" : "post"));
    }
}

TEST(OpenApi, SaysWhatARequestTakesAndWhatItGets) {
    const auto document = json_text::parse(openapi_json(with_description(some_routes())));
    const auto paths = field(document, "paths").struct_value();
    const auto kick = field(field(paths, "/api/v1/kick").struct_value(), "post").struct_value();
    EXPECT_THAT(kick.DebugString(), HasSubstr("#/components/schemas/KickRequest"));
    EXPECT_THAT(kick.DebugString(), HasSubstr("#/components/schemas/Done"));
    EXPECT_THAT(kick.DebugString(), HasSubstr("application/problem+json"));
    const auto schemas =
        field(field(document, "components").struct_value(), "schemas").struct_value();
    // What a message holds is there too, and what nobody uses is not.
    EXPECT_THAT(
        field_names(schemas),
        UnorderedElementsAre(
            "Done", "KickRequest", "Problem", "SessionFigures", "SessionList", "SettingChange"));
    const auto entity = field(paths, "/api/v1/entities/{id}").DebugString();
    EXPECT_THAT(entity, HasSubstr("\"id\""));
    const auto sessions = field(paths, "/api/v1/sessions").DebugString();
    EXPECT_THAT(sessions, HasSubstr("only greater numbers"));
    EXPECT_THAT(sessions, HasSubstr("\"token\""));
    EXPECT_THAT(field(paths, "/healthz").DebugString(), testing::Not(HasSubstr("\"token\"")));
}

TEST(OpenApi, AnswersAsADocumentAndAsAPage) {
    const std::vector<AdminRoute> routes = with_description(some_routes());
    for (const AdminRoute& route : routes) {
        if (route.path != "/api" && route.path != "/api/v1/openapi.json") {
            continue;
        }
        EXPECT_TRUE(route.open);
        AdminResponse got;
        const AdminRequest request;
        route.handle(AdminCall{request, 0, {}}, [&](AdminResponse response) { got = response; });
        EXPECT_EQ(got.status, 200U);
        EXPECT_THAT(got.body, HasSubstr("/api/v1/kick"));
        if (route.path == "/api") {
            EXPECT_THAT(got.body, HasSubstr("Clients &lt;all&gt;"));
            EXPECT_THAT(got.body, HasSubstr("client, account, name, reason"));
        }
    }
}

}  // namespace
}  // namespace zoned::admin
