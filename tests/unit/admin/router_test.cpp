#include "server/admin/admin_router.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace zoned::admin {
namespace {

const std::string kRouterToken(64, 'a');

/// Routes that say which of them was called.
std::vector<AdminRoute> routes() {
    const auto say = [](const std::string& text) {
        return [text](const AdminCall& call, const AdminReply& reply) {
            AdminResponse response;
            response.body = text + " " + std::to_string(call.id);
            for (const auto& [name, value] : call.query) {
                response.body += " " + name + "=" + value;
            }
            reply(response);
        };
    };
    return {{"GET", "/open", true, say("open")},
            {"GET", "/closed", false, say("closed")},
            {"POST", "/order", false, say("order")},
            {"GET", "/things/{id}", false, say("thing")}};
}

AdminRequest get(const std::string& target) {
    AdminRequest request;
    request.method = "GET";
    request.target = target;
    request.host = "127.0.0.1:7900";
    request.authorization = "Bearer " + kRouterToken;
    return request;
}

AdminRequest post(const std::string& target) {
    AdminRequest request = get(target);
    request.method = "POST";
    request.content_type = "application/json";
    return request;
}

class Router : public ::testing::Test {
  protected:
    AdminResponse ask(const AdminRequest& request, double now_s = 0.0) {
        AdminResponse out;
        int replies = 0;
        router.handle(request, now_s, [&](AdminResponse response) {
            out = std::move(response);
            ++replies;
        });
        EXPECT_EQ(replies, 1);
        return out;
    }

    /// The status of a refusal, which is counted under `reason` and explains itself.
    unsigned refused(const AdminRequest& request, const std::string& reason) {
        const AdminResponse response = ask(request);
        EXPECT_EQ(router.refused().count(reason), 1U) << reason;
        EXPECT_EQ(response.content_type, "application/problem+json");
        EXPECT_NE(response.body.find("\"detail\": \""), std::string::npos) << response.body;
        return response.status;
    }

    AdminRouter router{kRouterToken, routes()};
};

TEST_F(Router, CallsTheRouteOfThePathWithItsNumberAndQuery) {
    EXPECT_EQ(ask(get("/closed")).body, "closed 0");
    EXPECT_EQ(ask(get("/things/17?after=3&limit=9")).body, "thing 17 after=3 limit=9");
    EXPECT_EQ(ask(post("/order")).body, "order 0");
    EXPECT_TRUE(router.refused().empty());
}

TEST_F(Router, LetsNobodyInWithoutTheToken) {
    AdminRequest request = get("/closed");
    request.authorization = "";
    EXPECT_EQ(refused(request, "token_missing"), 401U);
    request.authorization = "Bearer " + std::string(64, 'b');
    EXPECT_EQ(refused(request, "token_wrong"), 401U);
    request.authorization = "Bearer " + kRouterToken + "a";
    EXPECT_EQ(ask(request).status, 401U);
    request.authorization = "Basic " + kRouterToken;
    EXPECT_EQ(ask(request).status, 401U);
    request.target = "/open";
    EXPECT_EQ(ask(request).status, 200U);
}

TEST_F(Router, LooksAtFewWrongTokensASecondAndAtRightOnesAlways) {
    AdminRequest wrong = get("/closed");
    wrong.authorization = "Bearer x";
    int unauthorized = 0;
    for (int i = 0; i < 1000; ++i) {
        unauthorized += ask(wrong).status == 401U ? 1 : 0;
    }
    EXPECT_EQ(unauthorized, 20);  // the burst: twice kWrongTokensPerSecond
    EXPECT_EQ(router.refused().at("token_flood"), 980U);
    EXPECT_EQ(ask(get("/closed")).status, 200U);
    EXPECT_EQ(ask(wrong, 1.0).status, 401U);
}

TEST_F(Router, RefusesPathTricks) {
    for (const char* target : {"",
                               "closed",
                               "//closed",
                               "/./closed",
                               "/../closed",
                               "/things/../closed",
                               "/closed/..",
                               "/%63losed",
                               "/closed%00",
                               "/closed\\",
                               "/closed;a=b",
                               "http://127.0.0.1/closed",
                               "*"}) {
        EXPECT_EQ(refused(get(target), "path"), 400U) << target;
    }
    EXPECT_EQ(refused(get("/closed/"), "not_found"), 404U);
    EXPECT_EQ(ask(get("/Closed")).status, 404U);
    EXPECT_EQ(refused(get("/" + std::string(2000, 'a')), "target_long"), 414U);
    EXPECT_EQ(refused(get("/closed?token=" + kRouterToken), "token_in_target"), 400U);
}

TEST_F(Router, TakesOnlyNumbersFromOneOnForAnId) {
    for (const char* id : {"", "0", "-1", "x", "1x", "4294967296", "0x1", "1/2"}) {
        EXPECT_EQ(ask(get(std::string("/things/") + id)).status, 404U) << id;
    }
}

TEST_F(Router, NamesTheMethodsOfAPath) {
    const AdminResponse response = ask(post("/closed"));
    EXPECT_EQ(response.status, 405U);
    ASSERT_EQ(response.headers.size(), 1U);
    EXPECT_EQ(response.headers[0], (std::pair<std::string, std::string>("Allow", "GET")));
}

TEST_F(Router, RefusesPagesOfOtherSites) {
    AdminRequest request = post("/order");
    request.origin = "https://evil.example";
    EXPECT_EQ(refused(request, "origin"), 403U);
    request.origin = "http://127.0.0.1:1";  // another port is another site
    EXPECT_EQ(ask(request).status, 403U);
    request.origin = "null";
    EXPECT_EQ(ask(request).status, 403U);
    request.origin = "http://127.0.0.1:7900";
    EXPECT_EQ(ask(request).status, 200U);
    request.fetch_site = "cross-site";
    EXPECT_EQ(ask(request).status, 403U);
}

TEST_F(Router, RefusesFormsOfOtherSites) {
    AdminRequest request = post("/order");
    request.content_type = "text/plain";
    EXPECT_EQ(refused(request, "content_type"), 415U);
    request.content_type = "";
    EXPECT_EQ(ask(request).status, 415U);
    request.content_type = "application/json; charset=utf-8";
    EXPECT_EQ(ask(request).status, 200U);
}

TEST_F(Router, AnswersOnlyToNamesThatNobodyCanPointHere) {
    for (const char* host :
         {"evil.example:7900", "", "127.0.0.1.evil.example", "127.evil", "[::1"}) {
        AdminRequest request = get("/open");
        request.host = host;
        EXPECT_EQ(refused(request, "host"), 421U) << host;
    }
    for (const char* host :
         {"localhost", "localhost:7900", "127.0.0.1", "127.1.2.3:80", "[::1]:80"}) {
        EXPECT_TRUE(is_loopback_host(host)) << host;
    }
    EXPECT_FALSE(is_loopback_host("localhost:80evil"));
}

}  // namespace
}  // namespace zoned::admin
