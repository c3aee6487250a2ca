"""lift_lab"""
