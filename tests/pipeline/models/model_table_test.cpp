#include <gtest/gtest.h>

#include <oncollide/pipeline/models/fault_log.hpp>
#include <oncollide/pipeline/models/model_table.hpp>

namespace oncollide::model_table_test {
namespace {

std::shared_ptr<const Geometry> ball(double radius)
{
    return std::make_shared<const Geometry>(Geometry{"ball", Sphere{radius}, {}});
}

TEST(ModelTable, GivesASlotAgainUnderAnotherGeneration)
{
    ModelTable table(7);
    const ModelId first = table.add(ball(1)), second = table.add(ball(2));
    EXPECT_EQ(table.size(), 2u);
    EXPECT_TRUE(table.valid(first));
    table.remove(first);
    EXPECT_FALSE(table.valid(first));
    const ModelId third = table.add(ball(3));
    EXPECT_EQ(third.slot, first.slot) << "the free slot is used";
    EXPECT_NE(third, first);
    EXPECT_FALSE(table.valid(first)) << "an old id stays invalid";
    EXPECT_TRUE(table.valid(second));
    EXPECT_EQ(table.slots(), 2u);
    EXPECT_FALSE(table.valid(ModelTable(8).add(ball(1)))) << "an id of another World";
}

TEST(ModelTable, CopiesAGeometryOnceToChangeIt)
{
    ModelTable table(1);
    const std::shared_ptr<const Geometry> shared = ball(1);
    const ModelId id = table.add(shared);
    const std::shared_ptr<Geometry> own = table.own(id);
    EXPECT_NE(own, shared) << "a geometry that others may hold is not changed";
    table.replace(id, own);
    EXPECT_EQ(table.own(id), own) << "the table's own copy is";
    table.replace(id, shared);
    EXPECT_NE(table.own(id), own) << "another geometry ends that";
    EXPECT_TRUE(table.valid(id)) << "replace() keeps the id";
}

TEST(ModelTable, TransientModelsHaveOddNumbersAndDoNotCount)
{
    ModelTable table(1);
    const ModelId id = table.add(ball(1));
    Model &a = table.add_transient(ball(2)), &b = table.add_transient(ball(3));
    EXPECT_EQ(table.size(), 1u);
    EXPECT_NE(a.number(), b.number());
    for (Model* model : {&a, &b}) {
        EXPECT_EQ(model->number() % 2, 1u);
        EXPECT_EQ(&table.by_number(model->number()), model);
    }
    EXPECT_EQ(&table.by_number(table[id].number()), &table[id]);
    const std::uint32_t number = a.number();
    table.remove_transient(a);
    EXPECT_EQ(table.add_transient(ball(4)).number(), number) << "free places are used again";
}

TEST(FaultLog, CountsTheResultsOfAReasonAndAddsOthersOnce)
{
    FaultLog log;
    log.note("hill.onc: chunk 3 is damaged"), log.note("hill.onc: chunk 3 is damaged"), log.note("no room");
    EXPECT_EQ(log.lines({"no room", "sea.onc is missing"}),
              (std::vector<std::string>{"hill.onc: chunk 3 is damaged (2 results undecided)",
                                        "no room (1 result undecided)", "sea.onc is missing"}));
}

} // namespace
} // namespace oncollide::model_table_test
