#include "core/color/color_csv.h"

#include <gtest/gtest.h>

#include "core/base/error.h"

namespace reseau {
namespace {

std::string complaint(std::string_view text) {
  try {
    (void)parse_color_csv(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(ColorCsv, TakesWhatSpreadsheetsWrite) {
  const CsvText expected = parse_color_csv("a,b\n1,2\n3,4\n");
  for (const char* text :
       {"\xEF\xBB\xBF"
        "a,b\r\n1,2\r\n3,4\r\n",
        "a,b\r1,2\r3,4", "# a word\n\na , b\n 1, 2\n\n3 ,4\n", "\"a\",\"b\"\n\"1\",2\n3,4\n",
        "a\tb\n1\t2\n3\t4\n", "a;b\n1;2\n3;4\n"}) {
    const CsvText table = parse_color_csv(text);
    EXPECT_EQ(table.columns, expected.columns) << text;
    ASSERT_EQ(table.rows.size(), 2u) << text;
    EXPECT_EQ(table.rows[0].fields, expected.rows[0].fields) << text;
    EXPECT_EQ(table.rows[1].fields, expected.rows[1].fields) << text;
  }
}

TEST(ColorCsv, UnderstandsDecimalCommasWhereTheyCannotSeparate) {
  const CsvText table = parse_color_csv("a;b\n1,5;2\n");
  EXPECT_TRUE(table.decimal_comma);
  EXPECT_EQ(table.notes.size(), 1u);
  EXPECT_EQ(csv_number(table.rows[0].fields[0], true, 2, "a"), 1.5);
  EXPECT_NE(complaint("a,b\n1,5,2,5\n").find("semicolons"), std::string::npos);
  EXPECT_THROW((void)csv_number("1.234,5", true, 2, "a"), InputError);
}

TEST(ColorCsv, RefusesWhatIsNoTable) {
  EXPECT_NE(complaint("").find("empty"), std::string::npos);
  EXPECT_NE(complaint("\xEF\xBB\xBF").find("empty"), std::string::npos);
  EXPECT_NE(complaint("# only a comment\n").find("empty"), std::string::npos);
  EXPECT_NE(complaint("a,b\n").find("nothing below"), std::string::npos);
  EXPECT_NE(complaint("400,0.1\n410,0.1\n").find("no header line"), std::string::npos);
  EXPECT_NE(complaint("400,0.1,0.1,0.2\n").find("no header line"), std::string::npos);
  EXPECT_NE(complaint("a,a\n1,2\n").find("two columns"), std::string::npos);
  EXPECT_NE(complaint(std::string_view("a\0,\0b\0\n\0", 8)).find("UTF-8"), std::string::npos);
  EXPECT_NE(complaint("a,b\n1\n").find("Line 2"), std::string::npos);
  EXPECT_NE(complaint(std::string((16U << 20) + 1, 'a')).find("larger"), std::string::npos);
}

TEST(ColorCsv, NumbersAreFiniteAndWhole) {
  EXPECT_EQ(csv_number("+1e2", false, 1, "x"), 100);
  for (const char* text : {"", "nan", "inf", "-inf", "1e999", "0x10", "12 nm", "1,5", "--1"}) {
    EXPECT_THROW((void)csv_number(text, false, 1, "x"), InputError) << text;
  }
}

}  // namespace
}  // namespace reseau
