#include "server/admin/metrics_text.h"

#include <gtest/gtest.h>

#include <limits>

namespace zoned::admin {
namespace {

TEST(MetricsText, WritesFamiliesAndEscapesLabels) {
    MetricsText out;
    out.single("a_total", "counter", "Things.", 3.0);
    out.family("b", "gauge", "Others.");
    out.sample(0.25, {{"x", "quote \" slash \\ line \n"}, {"y", "z"}});
    out.sample(std::numeric_limits<double>::infinity());
    EXPECT_EQ(out.text(),
              "# HELP a_total Things.\n# TYPE a_total counter\na_total 3\n"
              "# HELP b Others.\n# TYPE b gauge\n"
              "b{x=\"quote \\\" slash \\\\ line \\n\",y=\"z\"} 0.25\n"
              "b +Inf\n");
}

TEST(MetricsText, ContinuesTheNameOfASummary) {
    MetricsText out;
    out.family("t", "summary", "Times.");
    out.sample_of("_count", 2.0);
    EXPECT_EQ(out.text(), "# HELP t Times.\n# TYPE t summary\nt_count 2\n");
}

}  // namespace
}  // namespace zoned::admin
