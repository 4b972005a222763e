// The schema of the settings: every number has a range that its default keeps.
#include "proto/config/config.pb.h"

#include <google/protobuf/descriptor.h>
#include <gtest/gtest.h>

#include <set>
#include <string>

namespace zoned::config {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;

double default_of(const FieldDescriptor& field) {
    switch (field.cpp_type()) {
        case FieldDescriptor::CPPTYPE_DOUBLE:
            return field.default_value_double();
        case FieldDescriptor::CPPTYPE_UINT32:
            return field.default_value_uint32();
        case FieldDescriptor::CPPTYPE_UINT64:
            return static_cast<double>(field.default_value_uint64());
        default:
            ADD_FAILURE() << field.full_name() << " has a type that the range checks do not know";
            return 0.0;
    }
}

void check(const Descriptor& message, std::set<const Descriptor*>& seen, int& numbers) {
    if (!seen.insert(&message).second) {
        return;
    }
    for (int i = 0; i < message.field_count(); ++i) {
        const FieldDescriptor& field = *message.field(i);
        SCOPED_TRACE(field.full_name());
        const bool has_range = field.options().HasExtension(proto::range);
        const proto::FieldRange& range = field.options().GetExtension(proto::range);
        if (field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
            EXPECT_EQ(has_range, field.is_repeated()) << "lists of messages state their length";
            check(*field.message_type(), seen, numbers);
        } else if (field.cpp_type() == FieldDescriptor::CPPTYPE_STRING) {
            EXPECT_TRUE(has_range) << "strings state their length in bytes";
            if (field.has_default_value()) {
                EXPECT_GE(static_cast<double>(field.default_value_string().size()), range.min());
            }
        } else if (field.cpp_type() != FieldDescriptor::CPPTYPE_ENUM &&
                   field.cpp_type() != FieldDescriptor::CPPTYPE_BOOL) {
            ++numbers;
            EXPECT_TRUE(has_range && range.has_min() && range.has_max());
            EXPECT_LT(range.min(), range.max());
            if (field.has_default_value()) {
                EXPECT_GE(default_of(field), range.min());
                EXPECT_LE(default_of(field), range.max());
            }
        }
    }
}

TEST(ConfigSchema, GivesEveryNumberARangeThatItsDefaultKeeps) {
    std::set<const Descriptor*> seen;
    int numbers = 0;
    check(*proto::config::Config::descriptor(), seen, numbers);
    // A guard against a test that walks nothing: the schema has far more numbers than this.
    EXPECT_GT(numbers, 100);
}

}  // namespace
}  // namespace zoned::config
