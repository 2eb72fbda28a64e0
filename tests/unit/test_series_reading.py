"""Every way in which a CSV series can be refused: file, row and column in one line."""

from __future__ import annotations

import numpy as np
import pytest

from gearfem.foundation import InputError
from gearfem.foundation.columns import read_columns

HEADERS = (("roll_length_mm", "deviation_um"), ("x_mm", "y_mm"))


def test_numbers_come_back_without_comments_and_empty_lines(tmp_path):
    file = tmp_path / "flank.csv"
    file.write_text("\ufeff# probe\f3\u2028\n\n x_mm , y_mm\n1,2\n# a remark\n\n3e0, -4\n", encoding="utf-8")
    found = read_columns(file, HEADERS)
    assert found.names == ("x_mm", "y_mm")
    np.testing.assert_array_equal(found.values, [[1.0, 2.0], [3.0, -4.0]])


FAULTS = {
    "another header": ("x_mm,z_mm\n1,2\n", "header (line 1)", "x_mm,y_mm"),
    "columns in another order": ("y_mm,x_mm\n1,2\n", "header (line 1)", "x_mm,y_mm"),
    "no header": ("# nothing\n", "header", "x_mm,y_mm"),
    "ragged": ("# one\nx_mm,y_mm\n1,2\n1,2,3\n", "row 2 (line 4)", "2 columns"),
    "short": ("x_mm,y_mm\n1,2\n1\n", "row 2 (line 3)", "2 columns"),
    "NaN": ("x_mm,y_mm\n1,nan\n", "row 1 (line 2), column y_mm", "finite"),
    "infinite": ("x_mm,y_mm\n1,2\n-inf,2\n", "row 2 (line 3), column x_mm", "finite"),
    "text": ("x_mm,y_mm\n1,2\n3,4 um\n", "row 2 (line 3), column y_mm", "finite"),
    "nothing": ("x_mm,y_mm\n1,\n", "row 1 (line 2), column y_mm", "finite"),
    "decimal comma": ("x_mm,y_mm\n1,5,2,5\n", "row 1 (line 2)", "2 columns"),
    "a digit of another script": ("x_mm,y_mm\n1,\uff12\n", "row 1 (line 2), column y_mm", "finite"),
    "no measurement": ("x_mm,y_mm\n1,1e200\n", "row 1 (line 2), column y_mm", "below 1e+15"),
    "an open quote": ('x_mm,y_mm\n1,"2\n', "row 1 (line 2)", "quotes in pairs"),
    "an endless cell": ("x_mm,y_mm\n1," + 200_000 * "2" + "\n", "row 1 (line 2)", "fields parted by commas"),
    "no rows": ("x_mm,y_mm\n", "rows", "from 1"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_faults_name_row_and_column(fault, tmp_path):
    text, where, allowed = FAULTS[fault]
    file = tmp_path / "flank.csv"
    file.write_text(text)
    with pytest.raises(InputError) as refusal:
        read_columns(file, HEADERS)
    assert refusal.value.where == where
    assert allowed in refusal.value.allowed
    assert refusal.value.file == str(file)
    assert "\n" not in str(refusal.value)


def test_files_that_cannot_be_read(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        read_columns(tmp_path / "none.csv", HEADERS)
    with pytest.raises(InputError, match="can be read"):
        read_columns(tmp_path, HEADERS)
    (tmp_path / "latin.csv").write_bytes(b"x_mm,y_mm\n1,2 \xb5m\n")
    with pytest.raises(InputError, match="UTF-8"):
        read_columns(tmp_path / "latin.csv", HEADERS)
