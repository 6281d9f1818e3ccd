"""The filters for programs: over numpy arrays, one reading at a time, and over recorded flights.

``attest_mav`` exports what is declared stable here.
"""
